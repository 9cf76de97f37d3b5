#include "analysis/tuning/tuning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/normal_quantile.h"
#include "analysis/tuning/scale_search.h"
#include "core/linear_algebra/cholesky.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

constexpr double kReach = 1e6;          // factor within which one is sought, from where the search begins
constexpr int kMostRestarts = 3;        // from the end of a search
constexpr double kWidestScale = 1.0;    // of the first steps of a search, in φ
constexpr double kNotConverged = 0.1;   // decrement at the end of a search
constexpr double kContradiction = 4.0;  // standard errors, of a filter that is wrong
constexpr double kWider = 2.0;          // standard errors, beyond which the wider intervals are taken
constexpr double kBetter = 1e-3;        // of the sum of the scores
constexpr int kResamples = 1000;

class Tuner {
 public:
  Tuner(const ScoreModel& model, const Vector& start, double confidence) : model_(model) {
    tuning_.start = tuning_.phi = start;
    tuning_.confidence = confidence;
    box_ = {start, start};
    box_ = reaching_from(start);
    before_ = model.scores(start, false);
    if (!before_.ok) {
      throw std::invalid_argument(
          "the present filter has no scores: no innovations, an S that is not positive definite, or a run "
          "that fails");
    }
    tuning_.steps = before_.steps;
    tuning_.units = model.units();
    tuning_.forecast = forecast_tuning(model, start, before_.steps);
    const Matrix& I = tuning_.forecast.information;
    scale_ = Vector::Constant(start.size(), kWidestScale);
    for (Index i = 0; i < I.rows(); ++i) {
      if (I(i, i) > 0.0) scale_[i] = std::min(scale_[i], 1.0 / std::sqrt(I(i, i)));
    }
    for (const auto& parameter : tuning_.forecast.parameters) free_.push_back(parameter.identifiable);
    reasons_.resize(free_.size());
    limits_.resize(free_.size());
    held_limits_.resize(free_.size());
    for (std::size_t i = 0; i < free_.size(); ++i) reasons_[i] = tuning_.forecast.parameters[i].reason;
  }

  Tuning run() {
    find();
    add_gain();
    add_values();
    add_notes();
    return std::move(tuning_);
  }

 private:
  /// The standard deviation of φ of which a normal interval is wider than kWidestNormalRatio.
  double widest_normal() const {
    return 0.5 * std::log(kWidestNormalRatio) / normal_quantile_two_sided(tuning_.confidence);
  }

  /// Seeks all free coordinates, from the best scales of their covariances, and holds one after the other
  /// that the data do not determine.
  void find() {
    tuning_.phi = best_scales(model_, tuning_.start, kReach);
    box_ = reaching_from(tuning_.phi);
    while (std::ranges::find(free_, true) != free_.end()) {
      tuning_.estimate = estimate_score(model_, tuning_.phi, box_, free_, scale_);
      if (!tuning_.estimate.ok) throw std::invalid_argument("the search left the filters that have scores");
      choose_covariance();
      if (go_on()) continue;
      const Index unknown = least_known();
      if (unknown < 0) break;
      if (!improve(unknown)) hold(unknown);
    }
    if (std::ranges::find(free_, true) == free_.end()) {
      tuning_.phi = tuning_.start;
      tuning_.estimate = {};
      covariance_.resize(0, 0);
      choose_covariance();
      return;
    }
    tuning_.phi = tuning_.estimate.phi;
  }

  /// The bounds, widened to those of a search that begins there.
  SearchBox reaching_from(const Vector& phi) const {
    const double reach = std::log(kReach);
    return {box_.lower.cwiseMin((phi.array() - reach).matrix()),
            box_.upper.cwiseMax((phi.array() + reach).matrix())};
  }

  /// Begins again from the end of the search where the score rises beyond it, a few times, and gives up then.
  /// False where the maximum lies within, or the score is flat at the end.
  bool go_on() {
    constexpr double kRounding = 1e-3;  // of φ, within which a search stops at its box
    const Vector end = tuning_.estimate.phi;
    for (const Index c : tuning_.estimate.free) {
      if (end[c] > box_.lower[c] + kRounding && end[c] < box_.upper[c] - kRounding) continue;
      const SearchBox narrow = box_;
      box_ = reaching_from(end);
      const Maximum beyond = maximise(model_, end, box_, free_, scale_);
      if (!beyond.ok || beyond.value < tuning_.estimate.value + kBetter) {
        box_ = narrow;
        continue;
      }
      if (++restarts_ > kMostRestarts) {
        give_up(c);
      } else {
        tuning_.phi = beyond.phi;
      }
      return true;
    }
    return false;
  }

  /// Where one runs away the others are those of a filter that nobody wants.
  void give_up(Index coordinate) {
    endless_ = coordinate;
    const std::string& name = tuning_.forecast.parameters[static_cast<std::size_t>(coordinate)].name;
    const double factor = std::exp(tuning_.estimate.phi[coordinate] - tuning_.start[coordinate]);
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (!free_[i]) continue;
      free_[i] = false;
      reasons_[i] = static_cast<Index>(i) == coordinate
                        ? fmt::format(
                              "the score still rises at the end of the search, {:.0e} times the "
                              "present value",
                              factor)
                        : fmt::format("{} has no maximum", name);
    }
  }

  /// The coordinate that the data determine least, if they do not; else −1. Whatever they determine weakly
  /// has its limits then.
  Index least_known() {
    const ScoreEstimate& e = tuning_.estimate;
    std::ranges::fill(limits_, std::nullopt);
    // Without a positive definite curvature by the flattest direction's own.
    const auto variance = [&](Index at) {
      return covariance_.size() > 0 ? covariance_(at, at) : 1.0 / std::max(e.information(at, at), 1e-300);
    };
    std::vector<Index> places(e.free.size());
    std::iota(places.begin(), places.end(), Index{0});
    std::ranges::sort(places, std::greater<>{}, variance);
    for (const Index at : places) {
      const Index coordinate = e.free[static_cast<std::size_t>(at)];
      if (covariance_.size() == 0) return coordinate;
      const auto i = static_cast<std::size_t>(coordinate);
      const bool weak = std::sqrt(variance(at)) > widest_normal() ||
                        tuning_.forecast.parameters[i].relative_error > widest_normal();
      if (!weak) continue;
      limits_[i] = limits_of(coordinate);
      if (limits_[i]->upper - limits_[i]->lower > std::log(kWidestRatio)) return coordinate;
    }
    return -1;
  }

  /// Of the likelihood ratio, whose drop a wider sandwich widens.
  ProfileLimits limits_of(Index coordinate) const {
    const ScoreEstimate& e = tuning_.estimate;
    double drop = 0.5 * chi_square_quantile(tuning_.confidence, 1.0);
    if (tuning_.by_sandwich) {
      const Index at = std::ranges::find(e.free, coordinate) - e.free.begin();
      drop *= std::max(1.0, covariance_(at, at) / e.covariance(at, at));
    }
    const SearchBox around = reaching_from(e.phi);
    return profile_limits(model_, e, around, free_, scale_, coordinate, drop);
  }

  /// Where a factor has gone to 0 or ∞ the score is flat, also where another value were better: begins again
  /// from the best of a row of values of it, the others where the search ended or began. True where a better
  /// point was found.
  bool improve(Index coordinate) {
    constexpr int kEachWay = 12;
    if (!improved_.insert(coordinate).second) return false;
    const double value = tuning_.estimate.value;
    double best = value + kBetter;
    for (const Vector& others : {tuning_.estimate.phi, tuning_.start}) {
      Vector phi = others;
      for (int i = -kEachWay; i <= kEachWay; ++i) {
        phi[coordinate] = tuning_.start[coordinate] + i * 2.0 * std::log(kReach) / kEachWay;
        const UnitScores there = model_.scores(phi, false);
        if (!there.ok || there.sum() < best) continue;
        best = there.sum();
        tuning_.phi = phi;
      }
    }
    if (best == value + kBetter) return false;
    box_ = reaching_from(tuning_.phi);
    return true;
  }

  void hold(Index coordinate) {
    const auto i = static_cast<std::size_t>(coordinate);
    held_limits_[i] = limits_[i] ? *limits_[i] : limits_of(coordinate);
    reasons_[i] = "these data do not determine it";
    free_[i] = false;
    tuning_.phi = tuning_.estimate.phi;
    tuning_.phi[coordinate] =
        std::clamp(tuning_.start[coordinate], held_limits_[i].lower, held_limits_[i].upper);
  }

  /// Information or sandwich: which the unit scores ask for.
  void choose_covariance() {
    const ScoreEstimate& e = tuning_.estimate;
    covariance_ = e.covariance;
    tuning_.misspecified = tuning_.by_sandwich = false;
    tuning_.information_ratio = kNaN;
    mean_ratio_ = 1.0;
    if (covariance_.size() == 0) return;
    const auto units = static_cast<double>(e.unit_scores.cols());
    if (units < 2.0) return;
    const Matrix root = Eigen::LLT<Matrix>(e.covariance).matrixL();  // Lᵀ A L = I
    const Matrix whitened = root.transpose() * e.unit_scores;
    const Vector ratio = whitened.rowwise().squaredNorm();
    Index worst = 0;
    (ratio.array() - 1.0).abs().maxCoeff(&worst);
    tuning_.information_ratio = ratio[worst];
    const double error = std::sqrt(2.0 / units);
    tuning_.misspecified = !before_.composite && std::abs(ratio[worst] - 1.0) > kContradiction * error;
    tuning_.by_sandwich =
        before_.composite || tuning_.misspecified || ratio.maxCoeff() - 1.0 > kWider * error;
    if (!tuning_.by_sandwich) return;
    covariance_ = e.sandwich();
    mean_ratio_ = ratio.mean();
  }

  void add_gain() {
    tuning_.score_before = before_.sum() / before_.steps;
    tuning_.dof = before_.dof / before_.steps;
    tuning_.nis_before = before_.mean_nis();
    tuning_.lag_one_before = before_.lag_one_correlation();
    if (tuning_.estimate.free.empty()) return;
    const UnitScores after = model_.scores(tuning_.phi, false);
    tuning_.score_after = after.sum() / after.steps;
    tuning_.nis_after = after.mean_nis();
    tuning_.lag_one_after = after.lag_one_correlation();
    tuning_.likelihood_ratio = 2.0 * std::max(0.0, after.sum() - before_.sum());
    // What is held at a limit has moved, too. Of a filter that is wrong the ratio is a weighted sum of χ²(1),
    // whose mean is kept [Kent 1982].
    for (std::size_t i = 0; i < free_.size(); ++i) {
      const auto at = static_cast<Index>(i);
      if (free_[i] || tuning_.phi[at] != tuning_.start[at]) ++tuning_.likelihood_ratio_dof;
    }
    tuning_.likelihood_ratio_p_value =
        chi_square_survival(tuning_.likelihood_ratio / std::max(1.0, mean_ratio_),
                            static_cast<double>(tuning_.likelihood_ratio_dof));
    const std::vector<std::string> names = model_.names();
    for (const Index i : tuning_.estimate.free) {
      tuning_.coordinates.push_back(names[static_cast<std::size_t>(i)]);
    }
    const Vector deviation = covariance_.diagonal().cwiseSqrt();
    tuning_.correlation = covariance_.cwiseQuotient(deviation * deviation.transpose());
  }

  void add_values() {
    const std::vector<NoiseValue> before = model_.values(tuning_.start);
    const std::vector<NoiseValue> values = model_.values(tuning_.phi);
    const Matrix resampled = resample();
    for (std::size_t i = 0; i < values.size(); ++i) {
      TunedParameter& parameter = tuning_.parameters.emplace_back();
      parameter.name = values[i].name;
      parameter.before = before[i].value;
      const Index unknown = unknown_of(values[i]);
      if (unknown >= 0) {
        set_limits(before[i], unknown, parameter);
      } else {
        set_interval(values[i], resampled, parameter);
      }
    }
  }

  /// A coordinate on which the value depends and that was held; −1: none.
  Index unknown_of(const NoiseValue& value) const {
    for (Index i = 0; i < value.gradient.size(); ++i) {
      if (value.gradient[i] != 0.0 && !free_[static_cast<std::size_t>(i)]) return i;
    }
    return -1;
  }

  /// A value that is the exponential of one coordinate has the limits of that.
  void set_limits(const NoiseValue& before, Index coordinate, TunedParameter& parameter) const {
    const auto i = static_cast<std::size_t>(coordinate);
    parameter.reason = reasons_[i];
    if (endless_ >= 0) return;
    if (lone_coordinate(before) < 0 || !tuning_.forecast.parameters[i].identifiable) return;
    take_limits(before, tuning_.start, coordinate, held_limits_[i], parameter);
  }

  /// The only coordinate on which a positive value depends, as a power of its exponential; −1: there is none.
  static Index lone_coordinate(const NoiseValue& value) {
    Index only = -1;
    for (Index i = 0; i < value.gradient.size(); ++i) {
      if (value.gradient[i] == 0.0) continue;
      if (only >= 0 || !value.positive) return -1;
      only = i;
    }
    return only;
  }

  /// `value`: at `phi`.
  static void take_limits(const NoiseValue& value, const Vector& phi, Index coordinate,
                          const ProfileLimits& limits, TunedParameter& parameter) {
    const double power = value.gradient[coordinate] / value.value;
    parameter.lower = value.value * std::exp(power * (limits.lower - phi[coordinate]));
    parameter.upper = value.value * std::exp(power * (limits.upper - phi[coordinate]));
  }

  void set_interval(const NoiseValue& value, const Matrix& resampled, TunedParameter& parameter) const {
    const Vector gradient = value.gradient(tuning_.estimate.free);
    const double deviation = std::sqrt(gradient.dot(covariance_ * gradient));
    const double relative = deviation / std::abs(value.value);
    const double z = normal_quantile_two_sided(tuning_.confidence);
    parameter.identifiable = true;
    parameter.value = value.value;
    parameter.steps_for_10_percent = tuning_.steps * relative * relative / 0.01;
    std::vector<double> shifts(static_cast<std::size_t>(resampled.cols()));
    Vector::Map(shifts.data(), std::ssize(shifts)) = resampled.transpose() * gradient;
    std::ranges::sort(shifts);
    const auto place = [&](double share) {
      return shifts[static_cast<std::size_t>(std::lround(share * static_cast<double>(shifts.size() - 1)))];
    };
    const double tail = 0.5 * (1.0 - tuning_.confidence);
    const double low = shifts.empty() ? kNaN : place(tail), high = shifts.empty() ? kNaN : place(1.0 - tail);
    const auto moved = [&](double shift) {
      return value.positive ? value.value * std::exp(shift / value.value) : value.value + shift;
    };
    parameter.lower = moved(-z * deviation);
    parameter.upper = moved(z * deviation);
    parameter.bootstrap_lower = moved(low);
    parameter.bootstrap_upper = moved(high);
    const Index only = lone_coordinate(value);
    if (only < 0 || !limits_[static_cast<std::size_t>(only)]) return;
    parameter.by_likelihood_ratio = true;
    take_limits(value, tuning_.phi, only, *limits_[static_cast<std::size_t>(only)], parameter);
  }

  /// Errors of the estimate by drawing as many units as there are, with replacement, and one Newton step
  /// each: a column for each resample.
  Matrix resample() const {
    const ScoreEstimate& e = tuning_.estimate;
    const Index units = e.unit_scores.cols(), p = e.unit_scores.rows();
    if (units < 2 || e.covariance.size() == 0) return Matrix(p, 0);
    constexpr std::uint64_t kSeed = 20250101;
    std::mt19937_64 random(kSeed);
    Matrix moves(p, kResamples);
    for (int r = 0; r < kResamples; ++r) {
      Vector sum = Vector::Zero(p);
      for (Index i = 0; i < units; ++i) {
        sum += e.unit_scores.col(static_cast<Index>(random() % static_cast<std::uint64_t>(units)));
      }
      moves.col(r) = e.covariance * sum;
    }
    return moves;
  }

  void add_notes() {
    auto& notes = tuning_.notes;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (free_[i]) continue;
      notes.push_back(fmt::format("{} is held: {}.", tuning_.forecast.parameters[i].name, reasons_[i]));
    }
    if (endless_ >= 0) {
      notes.push_back(fmt::format("No value is given: for {} {}.",
                                  tuning_.forecast.parameters[static_cast<std::size_t>(endless_)].name,
                                  reasons_[static_cast<std::size_t>(endless_)]));
      return;
    }
    if (!tuning_.anything_known()) {
      notes.emplace_back("Nothing that was asked for can be told from these data: no value is given.");
      return;
    }
    if (!std::ranges::all_of(free_, std::identity())) {
      notes.emplace_back(
          "Values and intervals are those with what is held as it is: where that is wrong they need not hold "
          "the truth.");
    }
    for (Index i = 0; i < tuning_.correlation.rows(); ++i) {
      for (Index j = 0; j < i; ++j) {
        const double r = tuning_.correlation(i, j);
        if (std::abs(r) < kRidgeCorrelation) continue;
        notes.push_back(
            fmt::format("Ridge: the estimates of {} and {} have correlation {:.3f}; only a combination of "
                        "them is well known.",
                        tuning_.coordinates[static_cast<std::size_t>(j)],
                        tuning_.coordinates[static_cast<std::size_t>(i)], r));
      }
    }
    tuning_.converged = !(tuning_.estimate.decrement > kNotConverged);
    if (!tuning_.converged) {
      notes.push_back(
          fmt::format("The search did not converge: the slope at its end promises to raise the score by {} "
                      "more. The values are those of the best trial; a filter that fails at some trials "
                      "makes it so, or a score that jumps.",
                      number_text(0.5 * tuning_.estimate.decrement, 2)));
    } else if (before_.composite) {
      notes.emplace_back(
          "Sensors of one step are scored apart, as if they were independent, which those that share a prior "
          "are not: intervals are by the sandwich. One innovation of all of them with its S has a "
          "likelihood.");
    } else if (tuning_.misspecified) {
      notes.push_back(fmt::format(
          "The scores vary {:.2f} times as much as they would if the tuned filter were right: intervals are "
          "by the sandwich, and no noise of this form makes the filter right.",
          tuning_.information_ratio));
    }
  }

  const ScoreModel& model_;
  Tuning tuning_;
  SearchBox box_;
  Vector scale_;
  UnitScores before_;
  Matrix covariance_;
  double mean_ratio_ = 1.0;  ///< of the variance of the scores over the information, where it is the sandwich
  std::vector<bool> free_;
  std::vector<std::string> reasons_;
  std::vector<std::optional<ProfileLimits>> limits_;  ///< of what was found, but weakly
  std::vector<ProfileLimits> held_limits_;            ///< of what is held
  int restarts_ = 0;                                  ///< from the end of the search
  Index endless_ = -1;        ///< the coordinate whose score rises without end; -1: none
  std::set<Index> improved_;  ///< coordinates for which other starts were tried
};

}  // namespace

Tuning tune(const ScoreModel& model, const Vector& start, double confidence) {
  return Tuner(model, start, confidence).run();
}

}  // namespace credence::internal
