#include "analysis/calibration/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/shape/coverage.h"
#include "analysis/laws/ten_stretches.h"
#include "core/nan.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

using UnitSums = std::vector<const CalibrationSum*>;

/// What is independent.
struct Units {
  std::string name;  ///< "runs", "stretches", or "" of none
  UnitSums sums;
  std::vector<CalibrationSum> tenths{};  ///< that `sums` are, where they are no runs or stretches themselves
};

constexpr std::string_view kTooFew = "fewer than five units";

/// Runs where there are enough, else the stretches of all: of one run as many as there are, of several their
/// tenths; nothing where those of some run are too short by what its errors tell of its memory.
Units units_of(std::span<const CalibrationRun> runs, double memory, bool only_tenths = false) {
  Units units;
  if (std::ssize(runs) >= kFewestRunsCompared) {
    units.name = "runs";
    for (const CalibrationRun& run : runs) units.sums.push_back(&run.whole);
    return units;
  }
  const auto suffice = [memory](const CalibrationRun& run, std::size_t stretches) {
    const auto rows = run.stretches.front().rows * std::ssize(run.stretches) / static_cast<Index>(stretches);
    return static_cast<double>(rows) >= shortest_stretch(run.correlation_time, memory);
  };
  const auto whole = [&](const CalibrationRun& run) {
    return !run.stretches.empty() && suffice(run, CalibrationRun::kTenths);
  };
  if (runs.empty() || !std::ranges::all_of(runs, whole)) return units;
  units.name = "stretches";
  const std::vector<CalibrationSum>& first = runs.front().stretches;
  if (runs.size() == 1 && !only_tenths && suffice(runs.front(), first.size())) {
    for (const CalibrationSum& stretch : first) units.sums.push_back(&stretch);
    return units;
  }
  for (const CalibrationRun& run : runs) {
    for (std::size_t s = 0; s < run.stretches.size(); ++s) {
      if (s % (run.stretches.size() / CalibrationRun::kTenths) == 0)
        units.tenths.push_back(run.stretches[s]);
      else
        units.tenths.back().merge(run.stretches[s]);
    }
  }
  for (const CalibrationSum& tenth : units.tenths) units.sums.push_back(&tenth);
  return units;
}

double per_row(double sum, const CalibrationSum& unit) { return sum / static_cast<double>(unit.rows); }

/// dof: of the NEES in each row.
MeanInterval interval_of(const SkewedMoments& moments, double confidence, double dof) {
  if (moments.count >= kFewestRunsCompared) return run_mean_interval(moments, confidence, dof);
  MeanInterval interval{.mean = moments.mean, .lower = kNaN, .upper = kNaN, .count = moments.count};
  interval.reason = kTooFew;
  return interval;
}

double p_value_of(const SkewedMoments& moments, double dof) {
  return moments.count >= kFewestRunsCompared ? run_mean_p_values(moments, 1.0, dof).two_sided() : kNaN;
}

/// The rows in a range of σ of the units that came there.
class RangeOfUnits {
 public:
  void add(const CalibrationSum::Bin& bin) {
    units_.push_back(&bin);
    rows_ += static_cast<double>(bin.rows);
    most_ = std::max(most_, static_cast<double>(bin.rows));
  }
  std::int64_t count() const { return std::ssize(units_); }

  /// Σ e²/σ² of each unit, with `factor` for each row that is missing to the most of any, over the sum of as
  /// many rows of this factor: its mean is 1 where that is the factor, even where σ follows the errors, so
  /// that they decide how many rows of a unit come here.
  SkewedMoments filled_up(double factor) const {
    SkewedMoments moments;
    for (const CalibrationSum::Bin* unit : units_)
      moments.add((unit->normalised / factor + (most_ - static_cast<double>(unit->rows))) / most_);
    return moments;
  }

  /// That of all rows, with the interval over the units.
  MeanInterval interval(double factor, double confidence) const {
    MeanInterval interval = run_mean_interval(filled_up(factor), confidence, 1.0);
    const double per_row = most_ * static_cast<double>(count()) / rows_;
    interval.mean = factor;
    for (double* const end : {&interval.lower, &interval.upper})
      *end = std::max(0.0, factor * (1.0 + per_row * (*end - 1.0)));
    return interval;
  }

 private:
  std::vector<const CalibrationSum::Bin*> units_;
  double rows_ = 0.0, most_ = 0.0;
};

std::vector<SigmaBin> sigma_bins(const CalibrationSum& all, const UnitSums& units, double confidence) {
  std::vector<SigmaBin> bins;
  for (const auto& [place, sums] : all.bins) {
    const auto rows = static_cast<double>(sums.rows);
    RangeOfUnits of_units;
    for (const CalibrationSum* unit : units) {
      const auto found = unit->bins.find(place);
      if (found != unit->bins.end()) of_units.add(found->second);
    }
    const std::int64_t came = of_units.count();
    const double factor = sums.normalised / rows;
    SigmaBin bin{.state = place.first,
                 .lower = std::pow(10.0, 0.25 * place.second),
                 .upper = std::pow(10.0, 0.25 * (place.second + 1)),
                 .claimed = std::sqrt(sums.variance / rows),
                 .rmse = std::sqrt(sums.squared / rows),
                 .rows = sums.rows,
                 .factor = {.mean = factor, .lower = kNaN, .upper = kNaN, .count = came},
                 .directed = {kNaN, kNaN},
                 .p_value = kNaN};
    if (came < kFewestRunsCompared) {
      bin.factor.reason = kTooFew;
    } else {
      if (factor > 0.0) {
        bin.factor = of_units.interval(factor, confidence);
      } else {
        bin.factor.reason = "every error is zero";
      }
      bin.directed = run_mean_p_values(of_units.filled_up(1.0), 1.0);
      bin.p_value = bin.directed.two_sided();
    }
    bins.push_back(bin);
  }
  adjust_by_holm(bins);
  return bins;
}

/// Of the states with more than one range.
ClaimedSigmaTest test_claimed_sigma(std::span<const SigmaBin> bins, const RunLayout& layout) {
  ClaimedSigmaTest result;
  double tests = 0.0;
  const auto add = [&](const SigmaBin& bin, double p_value, ClaimedSigmaTest::Side& side) {
    if (p_value >= side.p_value) return;
    side.p_value = p_value;
    side.factor = bin.factor;
    const std::string unit = unit_of_states(layout, {bin.state});
    side.in =
        fmt::format("{} where its σ is {} to {}{}{}", state_name(layout.states, bin.state),
                    number_text(bin.lower, 3), number_text(bin.upper, 3), unit.empty() ? "" : " ", unit);
  };
  for (const SigmaBin& bin : bins) {
    const bool constant = std::ranges::count(bins, bin.state, &SigmaBin::state) == 1;
    if (constant || std::isnan(bin.p_value)) continue;
    tests += 1.0;
    result.units = std::max(result.units, bin.factor.count);
    add(bin, bin.directed.optimistic, result.optimistic);
    add(bin, bin.directed.pessimistic, result.pessimistic);
  }
  for (ClaimedSigmaTest::Side* const side : {&result.optimistic, &result.pessimistic}) {
    if (tests > 0.0) side->p_value = std::min(1.0, 2.0 * tests * side->p_value);
  }
  return result;
}

SkewedMoments moments_of(const UnitSums& units, double CalibrationSum::*sum) {
  SkewedMoments moments;
  for (const CalibrationSum* unit : units) moments.add(per_row(unit->*sum, *unit));
  return moments;
}

/// Each unit with the factors of the others; `by_parts` false: one for all parts.
MeanInterval held_out(const UnitSums& units, double states, bool by_parts, double confidence) {
  SkewedMoments scaled;
  const std::size_t parts = units.empty() ? 0 : units.front()->marginal.size();
  const auto others = static_cast<double>(std::ssize(units) - 1);
  std::vector<double> sums(by_parts ? parts : 1, 0.0);
  const auto of = [&](const CalibrationSum& unit, std::size_t a) {
    return per_row(by_parts ? unit.marginal[a] : unit.nees, unit);
  };
  for (const CalibrationSum* unit : units) {
    for (std::size_t a = 0; a < sums.size(); ++a) sums[a] += of(*unit, a);
  }
  for (const CalibrationSum* unit : units) {
    const auto factor = [&](std::size_t part) {
      const std::size_t a = by_parts ? part : 0;
      return (sums[a] - of(*unit, a)) / others;
    };
    double nees = 0.0;
    std::size_t pair = 0;
    for (std::size_t a = 0; a < parts; ++a) {
      for (std::size_t b = a; b < parts; ++b) nees += unit->pairs[pair++] / std::sqrt(factor(a) * factor(b));
    }
    scaled.add(per_row(nees, *unit) / states);
  }
  return interval_of(scaled, confidence, states);
}

ConformalFactor conformal_factor(std::span<const CalibrationRun> runs) {
  ConformalFactor result{.runs = std::ssize(runs)};
  std::vector<double> scores;
  scores.reserve(runs.size());
  for (const CalibrationRun& run : runs) scores.push_back(run.coverage_factor);
  std::ranges::sort(scores);
  const auto at_rank = [&](std::size_t of) {  // NaN where there are too few
    const auto rank = static_cast<std::size_t>(std::ceil(kCovered * static_cast<double>(of)));
    return rank > 0 && rank <= scores.size() ? scores[rank - 1] : kNaN;
  };
  result.factor = at_rank(scores.size() + 1);
  result.least = at_rank(scores.size());
  return result;
}

std::vector<StanfordCell> stanford_cells(std::span<const CalibrationRun> runs) {
  std::map<std::pair<int, int>, std::int64_t> all;
  for (const CalibrationRun& run : runs) {
    for (const auto& [place, rows] : run.stanford) all[place] += rows;
  }
  const auto centre = [](int cell) { return std::pow(10.0, (cell + 0.5) / kStanfordCellsOfADecade); };
  std::vector<StanfordCell> cells;
  cells.reserve(all.size());
  for (const auto& [place, rows] : all) cells.push_back({centre(place.first), centre(place.second), rows});
  return cells;
}

std::vector<DistanceBin> distance_bins(std::span<const CalibrationRun> runs, double states,
                                       double confidence) {
  double length_m = 0.0;
  for (const CalibrationRun& run : runs) {
    if (!run.distance.bins().empty()) length_m = std::max(length_m, run.distance.length_m());
  }
  std::vector<DistanceSums::Bin> all;
  std::vector<SkewedMoments> moments;
  for (const CalibrationRun& run : runs) {
    DistanceSums sums = run.distance;
    sums.widen(length_m);
    all.resize(std::max(all.size(), sums.bins().size()));
    moments.resize(all.size());
    for (std::size_t i = 0; i < sums.bins().size(); ++i) {
      const DistanceSums::Bin& bin = sums.bins()[i];
      all[i].merge(bin);
      if (bin.rows > 0) moments[i].add(bin.nees / static_cast<double>(bin.rows));
    }
  }
  std::vector<DistanceBin> bins;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].rows == 0) continue;
    const auto rows = static_cast<double>(all[i].rows);
    DistanceBin bin{.from_m = length_m * static_cast<double>(i),
                    .to_m = length_m * static_cast<double>(i + 1),
                    .rows = all[i].rows,
                    .nees = interval_of(moments[i], confidence, states),
                    .p_value = p_value_of(moments[i], states),
                    .error_m = std::sqrt(all[i].squared / rows),
                    .sigma_m = std::sqrt(all[i].variance / rows)};
    bins.push_back(bin);
  }
  adjust_by_holm(bins);
  return bins;
}

ProtectionLevel protection_level(std::span<const CalibrationRun> runs, std::size_t r) {
  constexpr double kTail = 0.05;
  ProtectionLevel level{.risk = CalibrationRecorder::kRisks[r]};
  for (const CalibrationRun& run : runs) {
    if (run.position_dim == 0) continue;
    level.rows += run.whole.rows;
    level.beyond += run.beyond[r];
    level.effective_rows += run.effective_rows;
  }
  if (level.rows == 0) return level;
  const auto dof = static_cast<double>(runs.back().position_dim);
  level.k = std::sqrt(chi_square_upper_quantile(level.risk, dof));
  const auto total = static_cast<std::int64_t>(std::floor(level.effective_rows));
  const double share = static_cast<double>(level.beyond) / static_cast<double>(level.rows);
  const auto outside = std::min(total, static_cast<std::int64_t>(std::ceil(share * level.effective_rows)));
  const CoverageCount count{.inside = outside, .total = total};
  level.upper_limit = clopper_pearson(count, 1.0 - 2.0 * kTail).upper;
  level.needed_rows = std::log(kTail) / std::log1p(-level.risk);
  return level;
}

}  // namespace

std::string state_name(std::span<const std::string> states, Index state) {
  const auto i = static_cast<std::size_t>(state);
  return i < states.size() ? states[i] : fmt::format("x{}", state + 1);
}

Calibration judge_calibration(std::span<const CalibrationRun> runs, std::span<const Block> parts,
                              const RunLayout& layout, double confidence, double memory) {
  Calibration result;
  Units of_runs = units_of(runs, memory);
  const UnitSums& units = of_runs.sums;
  result.units = std::move(of_runs.name);
  result.unit_count = std::ssize(units);
  result.confidence = confidence;
  result.conformal = conformal_factor(runs);
  double dim = 0.0;
  for (const Block& part : parts) dim += static_cast<double>(part.states.size());
  for (std::size_t r = 0; r < result.protection.size(); ++r) result.protection[r] = protection_level(runs, r);
  result.stanford = stanford_cells(runs);
  result.distance = distance_bins(runs, dim, confidence);
  CalibrationSum all;
  for (const CalibrationRun& run : runs) all.merge(run.whole);
  result.rows = all.rows;
  result.bins = sigma_bins(all, units, confidence);
  result.claimed_sigma = test_claimed_sigma(result.bins, layout);
  result.whole = {"state", interval_of(moments_of(units, &CalibrationSum::nees), confidence, dim)};
  result.with_factor = held_out(units, dim, false, confidence);
  if (parts.size() < 2) return result;
  result.with_part_factors = held_out(units, dim, true, confidence);
  for (std::size_t a = 0; a < parts.size(); ++a) {
    SkewedMoments moments;
    for (const CalibrationSum* unit : units) moments.add(per_row(unit->marginal[a], *unit));
    result.parts.push_back(
        {parts[a].name, interval_of(moments, confidence, static_cast<double>(parts[a].states.size()))});
  }
  return result;
}

Calibration judge_calibration(CalibrationRecorder& recorder, double confidence) {
  const std::vector<CalibrationRun> runs = recorder.take();
  return judge_calibration(runs, recorder.parts(), recorder.layout(), confidence);
}

UnitFactors unit_factors(std::span<const CalibrationRun> runs, std::span<const Block> parts, double memory) {
  UnitFactors result;
  Units of_runs = units_of(runs, memory, true);
  const UnitSums& units = of_runs.sums;
  result.units = std::move(of_runs.name);
  for (const CalibrationRun& run : runs) {
    if (result.units == "runs") result.names.push_back(run.name);
    for (std::size_t s = 0; result.units == "stretches" && s < CalibrationRun::kTenths; ++s)
      result.names.push_back(fmt::format("{} {}", run.name, s + 1));
  }
  result.parts = {"NEES"};
  result.factors.resize(1);
  for (const CalibrationSum* unit : units) result.factors[0].push_back(per_row(unit->nees, *unit));
  for (std::size_t a = 0; a < parts.size() && parts.size() > 1; ++a) {
    result.parts.push_back(parts[a].name);
    std::vector<double>& factors = result.factors.emplace_back();
    for (const CalibrationSum* unit : units) factors.push_back(per_row(unit->marginal[a], *unit));
  }
  return result;
}

namespace {

/// Factors of the same units in two logs. Of exact filters their means agree, and not those of their
/// logarithms, which are the smaller the more a factor varies.
class PairedFactors {
 public:
  void add(double before, double after) {
    if (!(before > 0.0) || !(after > 0.0) || !std::isfinite(after / before)) return;
    before_.push_back(before);
    after_.push_back(after);
    before_mean_.add(before);
    after_mean_.add(after);
  }
  std::int64_t count() const { return before_mean_.count; }
  double before() const { return before_mean_.mean; }
  double after() const { return after_mean_.mean; }

  /// That the mean of the second is this times that of the first.
  double p_value(double ratio) const {
    SkewedMoments differences;
    constexpr double kRounding = 1e-12;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      const double difference = after_[i] - ratio * before_[i];
      differences.add(std::abs(difference) <= kRounding * after_[i] ? 0.0 : difference);
    }
    return paired_p_value(differences);
  }

  /// That the mean of both is 1.
  double p_value_of_middle() const {
    SkewedMoments sums;
    for (std::size_t i = 0; i < before_.size(); ++i) sums.add(before_[i] + after_[i] - 2.0);
    return paired_p_value(sums);
  }

  /// All ratios that this does not reject.
  MeanInterval ratio(double confidence) const {
    const double ratio = after() / before(), level = 1.0 - confidence;
    const auto excess = [&](double other) { return p_value(other) - level; };
    MeanInterval interval{.mean = ratio, .lower = 0.0, .upper = kInfinity, .count = count()};
    if (!(excess(ratio) > 0.0)) {
      interval.lower = interval.upper = ratio;
      return interval;
    }
    if (excess(0.0) < 0.0) interval.lower = border(0.0, ratio, excess);
    for (const double far : {2.0, 4.0, 16.0, 256.0, 65536.0}) {
      if (excess(far * ratio) >= 0.0) continue;
      interval.upper = border(ratio, far * ratio, excess);
      break;
    }
    return interval;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  /// Where between these `excess` changes its sign.
  static double border(double below, double above, const auto& excess) {
    std::uintmax_t evaluations = 100;
    const auto [low, high] = boost::math::tools::toms748_solve(
        excess, below, above, boost::math::tools::eps_tolerance<double>(30), evaluations);
    return 0.5 * (low + high);
  }

  std::vector<double> before_, after_;
  Moments before_mean_, after_mean_;
};

}  // namespace

std::vector<FactorChange> compare_factors(const UnitFactors& second, const UnitFactors& first,
                                          double confidence) {
  std::vector<FactorChange> changes;
  for (std::size_t a = 0; a < second.parts.size() && second.units == first.units; ++a) {
    const auto part = std::ranges::find(first.parts, second.parts[a]);
    if (part == first.parts.end()) continue;
    const std::vector<double>& before = first.factors[static_cast<std::size_t>(part - first.parts.begin())];
    PairedFactors paired;
    for (std::size_t i = 0; i < second.names.size(); ++i) {
      const auto unit = std::ranges::find(first.names, second.names[i]);
      if (unit == first.names.end()) continue;
      paired.add(before[static_cast<std::size_t>(unit - first.names.begin())], second.factors[a][i]);
    }
    if (paired.count() < 2) continue;
    FactorChange change{.part = second.parts[a],
                        .ratio = paired.ratio(confidence),
                        .before = paired.before(),
                        .after = paired.after(),
                        .p_value = paired.p_value(1.0),
                        .p_middle = paired.p_value_of_middle()};
    changes.push_back(std::move(change));
  }
  adjust_by_holm(changes);
  return changes;
}

Nearness nearness_of(const FactorChange& change, double level) {
  if (!(change.adjusted <= level && change.p_middle <= level)) return Nearness::open;
  const bool up = change.after > change.before, above = change.before + change.after > 2.0;
  return up == above ? Nearness::farther : Nearness::nearer;
}

}  // namespace credence::internal
