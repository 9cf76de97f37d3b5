#include "datasets/logs/time_offset.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/laws/mean/influence_interval.h"
#include "core/number_text.h"
#include "core/parallel_tasks.h"
#include "datasets/logs/truth_placement.h"
#include "montecarlo/engine/moments.h"

namespace credence::internal {
namespace {

constexpr double kFarthest_s = 1.0;
constexpr double kTaken = 0.1;       // of Σ eᵀP⁻¹e, at most, that leaves errors evidence
constexpr double kAgreement = 1e-4;  // level: errors that stay for a whole run look like an offset of it
constexpr double kBetween = 0.02;    // of Σ eᵀP⁻¹e, that offsets of each file must take away to matter

/// e_k(τ) of the samples of one file; nothing for those without a truth at their time.
class OffsetErrors {
 public:
  OffsetErrors(const PosesWithTruth& file, const TrajectoryMatching& matching)
      : file_(file), matching_(matching) {
    each(0.0, 1, [this](std::size_t i, const Step& step) {
      const Eigen::LLT<Matrix> factor(step.P);
      if (factor.info() != Eigen::Success) return;
      weights_[i] = factor.solve(Matrix::Identity(step.P.rows(), step.P.cols()));
    });
  }

  /// eᵀ P⁻¹ e over every `stride`-th sample.
  Moments nees(double tau, std::size_t stride) {
    Moments all;
    each(tau, stride, [&](std::size_t i, const Step& step) {
      if (weights_[i].rows() == step.error.size()) all.add(step.error.dot(weights_[i] * step.error));
    });
    return all;
  }

  /// g_k of the rows in order.
  RunScores scores(double tau) {
    constexpr double kDifference_s = 0.01;
    const auto at = errors(tau), before = errors(tau - kDifference_s), behind = errors(tau + kDifference_s);
    RunScores scores;
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (!at[i] || !before[i] || !behind[i] || weights_[i].rows() != at[i]->size() ||
          before[i]->size() != at[i]->size() || behind[i]->size() != at[i]->size()) {
        continue;
      }
      const Vector v = (*before[i] - *behind[i]) / (2.0 * kDifference_s);
      const Vector weighted = weights_[i] * v;
      scores.values.push_back(weighted.dot(*at[i]));
      scores.information.push_back(weighted.dot(v));
    }
    return scores;
  }

  std::size_t samples() const { return file_.samples.size(); }

 private:
  std::vector<std::optional<Vector>> errors(double tau) {
    std::vector<std::optional<Vector>> all(samples());
    each(tau, 1, [&](std::size_t i, const Step& step) { all[i] = step.error; });
    return all;
  }

  template <class Take>
  void each(double tau, std::size_t stride, Take take) {
    weights_.resize(samples());
    TrajectoryMatching shifted = matching_;
    shifted.time_offset_s = tau;
    shifted.truth_time = TruthTime::interpolated;  // e(τ) jumps between nearest ones, and stands still
    TruthPlacement placement;
    placement.motion =
        fitted_motion(file_.samples, *file_.truth, shifted, file_.axes, file_.joint_covariance, stride);
    const TruthComparison comparison(*file_.truth, shifted, file_.axes, file_.joint_covariance, placement);
    Step step;
    for (std::size_t i = 0; i < samples(); i += stride) {
      const EstimateSample& sample = file_.samples[i];
      const std::optional<UncertainPose> at = comparison.truth_at(sample.estimate.time_s);
      if (at && comparison.compare(sample.estimate, *at, sample.kept, step)) take(i, step);
    }
  }

  const PosesWithTruth& file_;
  TrajectoryMatching matching_;
  std::vector<Matrix> weights_;  ///< P⁻¹ at τ = 0; empty where there is none
};

/// The errors of all files, which threads look at one by one and which are added up in their order.
class CommonErrors {
 public:
  CommonErrors(std::span<const PosesWithTruth> files, const TrajectoryMatching& matching, int threads)
      : threads_(threads) {
    files_.resize(files.size());
    each([&](std::size_t f) { files_[f].emplace(files[f], matching); });
  }

  /// The costs at the grid's times, of some 256 rows of each file.
  std::vector<double> on_grid(std::span<const double> taus) {
    constexpr std::size_t kOnGrid = 256;
    std::vector<std::vector<Moments>> of_file(files_.size(), std::vector<Moments>(taus.size()));
    asked_ = 0;
    for (const auto& file : files_) asked_ += asked(*file, stride_for(*file, kOnGrid));
    each([&](std::size_t f) {
      for (std::size_t i = 0; i < taus.size(); ++i)
        of_file[f][i] = files_[f]->nees(taus[i], stride_for(*files_[f], kOnGrid));
    });
    std::vector<Moments> all(taus.size());
    for (const auto& file : of_file) {
      for (std::size_t i = 0; i < taus.size(); ++i) all[i].merge(file[i]);
    }
    std::vector<double> costs;
    costs.reserve(all.size());
    for (const Moments& nees : all) costs.push_back(cost(nees));
    return costs;
  }

  Moments nees(double tau) {
    std::vector<Moments> of_file(files_.size());
    each([&](std::size_t f) { of_file[f] = files_[f]->nees(tau, 1); });
    asked_ = 0;
    for (const auto& file : files_) asked_ += asked(*file, 1);
    Moments all;
    for (const Moments& file : of_file) all.merge(file);
    return all;
  }

  /// The mean; infinite where fewer than half of the rows that were asked for have a truth.
  double cost(const Moments& nees) const {
    return 2 * nees.count >= asked_ && nees.count > 0 ? nees.mean : std::numeric_limits<double>::infinity();
  }

  std::vector<RunScores> scores(double tau) {
    std::vector<RunScores> all(files_.size());
    each([&](std::size_t f) { all[f] = files_[f]->scores(tau); });
    return all;
  }

 private:
  static std::size_t stride_for(const OffsetErrors& file, std::size_t rows) {
    return std::max<std::size_t>(1, file.samples() / rows);
  }
  static std::int64_t asked(const OffsetErrors& file, std::size_t stride) {
    return static_cast<std::int64_t>(file.samples() / stride);
  }

  template <class Task>
  void each(Task task) {
    for_each_task(std::ssize(files_), threads_, nullptr,
                  [&](std::int64_t f) { task(static_cast<std::size_t>(f)); });
  }

  int threads_;
  std::vector<std::optional<OffsetErrors>> files_;
  std::int64_t asked_ = 0;  ///< rows
};

/// Why no time can be found in a truth of these times: most moments between two of them have one within the
/// limit on one side alone, so that nothing is compared there. "" where there is no such reason.
std::string too_coarse(const Trajectory& truth, double limit_s) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < truth.time_s.size(); ++i) gaps.push_back(truth.time_s[i] - truth.time_s[i - 1]);
  if (gaps.empty()) return "the truth has one row";
  const auto middle = gaps.begin() + std::ssize(gaps) / 2;
  std::ranges::nth_element(gaps, middle);
  // Of a gap g the moments with both ends within the limit L are 2 L − g; half of it, as cost() asks for.
  if (*middle <= 4.0 / 3.0 * limit_s) return "";
  constexpr double kRoom = 1.5;
  return fmt::format(
      "the truth has a row every {:.3g} s, of which one before and one behind an estimate must be within "
      "--max-time-difference {:g} s; with --max-time-difference {:.2g} the truth is interpolated between "
      "them",
      *middle, limit_s, kRoom * *middle);
}

/// The offsets that fit each file best, as far as they matter.
void compare_files(std::span<const RunScores> files, double nees, double p_agreement, TimeOffset& offset) {
  double between = 0.0, least = kNaN, most = kNaN;
  for (const RunScores& file : files) {
    double information = 0.0;
    for (const double I : file.information) information += I;
    if (!(information > 0.0)) continue;
    const double own = file.own();
    between += own * own * information;
    least = std::fmin(least, offset.value_s + own);
    most = std::fmax(most, offset.value_s + own);
  }
  if (!(p_agreement <= kAgreement) || !(between > kBetween * nees)) return;
  offset.p_agreement = p_agreement;
  offset.least_s = least;
  offset.most_s = most;
}

/// "0.03 s behind"
std::string order_text(double value_s, int digits) {
  return fmt::format("{:.{}g} s {}", std::abs(value_s), digits, value_s > 0.0 ? "behind" : "ahead of");
}

/// A sentence for the report.
std::string time_offset_text(const TimeOffset& offset) {
  if (!offset.estimated) {
    return fmt::format("The estimate's times were taken to be {} those of the truth (--time-offset).",
                       order_text(offset.value_s, 6));
  }
  if (std::isnan(offset.value_s)) {
    return fmt::format(
        "No time offset was used, as none could be estimated: {}. When the truth was is not "
        "known, so that no errors are evidence.",
        offset.reason);
  }
  const std::string whose = offset.files == 1
                                ? "The time offset"
                                : fmt::format("One time offset of all {} files together", offset.files);
  if (!std::isnan(offset.p_agreement)) {
    return fmt::format(
        "{} was estimated, and used: the estimate's times are {} those of the truth. But the files do not "
        "have one offset: {} to {} s fit each best (p = {}). Where their clocks differ, "
        "--time-offset each finds that of every file; as it is, when the truth was is not known, so that no "
        "errors are evidence.",
        whose, order_text(offset.value_s, 4), number_text(offset.least_s), number_text(offset.most_s),
        number_text(offset.p_agreement, 2));
  }
  const std::string unknown = fmt::format(
      "the word is optimistic only where the mean NEES is too large at every time within {:g} s, and never "
      "pessimistic.",
      kFarthest_s);
  if (!offset.reason.empty()) {
    return fmt::format(
        "{} of the least mean NEES was used: the estimate's times are {} those of the "
        "truth. It has no interval, as {}. That makes errors smaller by an unknown part: {}",
        whose, order_text(offset.value_s, 4), offset.reason, unknown);
  }
  const bool none = offset.lower_s <= 0.0 && offset.upper_s >= 0.0;
  return fmt::format(
      "{} was estimated from these errors, and used: the estimate's times are {} those of the "
      "truth ({} … {} at {:g} %, from {}){}. {}",
      whose, order_text(offset.value_s, 4), number_text(offset.lower_s), number_text(offset.upper_s),
      100.0 * offset.confidence,
      offset.whole_files ? "how the files differ" : fmt::format("{} rows", offset.rows),
      none ? "; no offset at all fits as well" : "",
      fit_of(offset) == TruthFit::none
          ? fmt::format("NEES is that of the best time, by at most {} % too small.",
                        number_text(100.0 * offset.taken, 2))
          : fmt::format("That makes NEES smaller by up to {} %: {}", number_text(100.0 * offset.taken, 2),
                        unknown));
}

}  // namespace

double time_of_least_cost(const std::function<std::vector<double>(std::span<const double> times_s)>& on_grid,
                          const std::function<double(double time_s)>& cost) {
  constexpr int kGrid = 50;  // points on each side
  constexpr double kStep = kFarthest_s / kGrid;
  std::vector<double> times_s;
  for (int i = -kGrid; i <= kGrid; ++i) times_s.push_back(i * kStep);
  int best = -kGrid;
  double least = std::numeric_limits<double>::infinity();
  const std::vector<double> costs = on_grid(times_s);
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (costs[i] < least) {
      least = costs[i];
      best = static_cast<int>(i) - kGrid;
    }
  }
  if (std::abs(best) == kGrid) return kNaN;
  constexpr int kBits = 24;
  return boost::math::tools::brent_find_minima(cost, (best - 1) * kStep, (best + 1) * kStep, kBits).first;
}

TimeOffset find_time_offset(std::span<const PosesWithTruth> files, const TrajectoryMatching& matching,
                            int threads) {
  TimeOffset offset{.estimated = true, .files = std::ssize(files)};
  for (const PosesWithTruth& file : files) {
    offset.reason = too_coarse(*file.truth, matching.max_time_difference_s);
    if (!offset.reason.empty()) return offset;
  }
  CommonErrors errors(files, matching, threads);
  offset.value_s =
      time_of_least_cost([&](std::span<const double> times_s) { return errors.on_grid(times_s); },
                         [&](double time_s) { return errors.cost(errors.nees(time_s)); });
  if (std::isnan(offset.value_s)) {
    offset.reason = fmt::format("no time within {:g} s fits better than those beyond", kFarthest_s);
    return offset;
  }
  const std::vector<RunScores> scores = errors.scores(offset.value_s);
  double information = 0.0;
  for (const RunScores& file : scores) {
    offset.rows += std::ssize(file.values);
    for (const double I : file.information) information += I;
  }
  InfluenceInterval interval = influence_interval(scores, offset.confidence);
  offset.whole_files = interval.whole_runs;
  offset.reason = std::move(interval.reason);
  const Moments nees = errors.nees(offset.value_s);
  const double sum = nees.mean * static_cast<double>(nees.count);
  compare_files(scores, sum, interval.p_agreement, offset);
  if (!offset.reason.empty()) return offset;
  offset.lower_s = offset.value_s - interval.half_width;
  offset.upper_s = offset.value_s + interval.half_width;
  offset.taken = interval.half_width * interval.half_width * information / sum;
  if (!(interval.half_width < kFarthest_s))
    offset.reason = "its interval is wider than the times that were tried";
  return offset;
}

TruthFit fit_of(const TimeOffset& offset) {
  if (!offset.estimated) return TruthFit::none;
  if (std::isnan(offset.value_s) || !std::isnan(offset.p_agreement)) return TruthFit::not_found;
  return offset.reason.empty() && offset.taken <= kTaken ? TruthFit::none : TruthFit::least_nees;
}

TrajectoryMatching with_time_offset(const PosesWithTruth& file, const LogReading& options, LogSink& sink) {
  TrajectoryMatching matching = options.matching;
  const double named_s = matching.time_offset_s.value_or(0.0);
  const bool asked = matching.find_time_offset != TimeOffsetSearch::none;
  if (!asked && named_s == 0.0) return matching;
  TimeOffset offset{.value_s = named_s, .rows = std::ssize(file.samples)};
  if (asked) {
    offset = options.common_offset ? *options.common_offset : find_time_offset({&file, 1}, matching);
    matching.time_offset_s = std::isnan(offset.value_s) ? 0.0 : offset.value_s;
    sink.truth_fit(fit_of(offset));
  }
  sink.remark(time_offset_text(offset));
  sink.time_offset(std::move(offset));
  return matching;
}

}  // namespace credence::internal
