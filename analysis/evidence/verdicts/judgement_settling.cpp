#include "analysis/evidence/verdicts/judgement_settling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/causes/advice.h"
#include "analysis/evidence/sums/effective_steps.h"
#include "analysis/laws/correlation/thinned_series.h"
#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/sample_size.h"
#include "analysis/laws/ten_stretches.h"
#include "core/nan.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

VerdictDesign design_of(const ConsistencyVerdict& v, double runs, bool white, double effective_steps) {
  const auto steps = static_cast<double>(std::max<std::int64_t>(1, v.steps_tested));
  const double effective = std::isfinite(effective_steps) ? std::clamp(effective_steps, 1.0, steps) : 1.0;
  return {.steps = steps,
          .dof_per_step = std::max(1e-9, v.dof / (steps * runs)),
          .confidence = v.confidence,
          .white = white,
          .effective_steps = white ? steps : effective};
}

/// A run's length over the correlation time within the runs, about their common mean; NaN where nothing
/// varies.
double effective_steps_within(std::span<const std::vector<double>> runs) {
  std::size_t longest = 0;
  for (const std::vector<double>& run : runs) longest = std::max(longest, run.size());
  std::vector<std::vector<double>> series;
  for (const std::vector<double>& run : runs) series.push_back(thinned(run, longest).values);
  const EffectiveSample sample = effective_sample(series);
  if (!sample.reason.empty()) return kNaN;
  return unbiased_size(sample.size * sample.correlation_time, sample.correlation_time) /
         static_cast<double>(runs.size());
}

/// The runs that show a factor of this logarithm as so many do the detectable ones: they tell more by the
/// root of their number.
std::int64_t runs_that_show(double seen, const DetectableFactors& detectable, double runs) {
  const double ratio = std::log(seen > 0.0 ? detectable.above : detectable.below) / seen;
  return static_cast<std::int64_t>(std::ceil(std::min(runs * ratio * ratio, 1e15)));
}

/// By what factors P may be wrong for the averages of the stretches of one run, whose mean at the level of
/// the verdict is `decides`, to show it with kSettlingPower: the mean is as far below that factor as it is in
/// one of 1 − kSettlingPower.
SettlingRuns settle_stretches(const ConsistencyVerdict& v, const MeanInterval& decides,
                              const MeanInterval& spread) {
  const double square = decides.mean * decides.mean;
  SettlingRuns result{.observed_factor = decides.mean,
                      .detectable = {.below = square / (decides.upper * spread.upper),
                                     .above = square / (decides.lower * spread.lower)}};
  const double seen = std::log(decides.mean);
  if (v.verdict != Verdict::consistent) {
    result.reason = "the verdict is there";
  } else if (std::abs(seen) < 1e-4) {
    result.reason = "nothing deviates";
  } else {
    result.runs = runs_that_show(seen, result.detectable, 1.0);
  }
  return result;
}

/// Of the averages that are compared, of whole runs or of their stretches: they are worth what their scatter
/// tells, which of few is uncertain itself.
VerdictDesign design_of_units(const ConsistencyVerdict& v, const SkewedMoments& averages, double runs) {
  constexpr int kStudies = 200;  // a standard error of 2 points at a power of 0.9
  constexpr double kLeastSteps = 0.01;
  const auto units = static_cast<double>(averages.count);
  VerdictDesign design = design_of(v, runs, false, 1.0);
  design.steps = std::max(1.0, design.steps * runs / units);
  const double variance = averages.variance() * (1.0 + 4.0 / units) / (averages.mean * averages.mean);
  design.effective_steps = std::clamp(2.0 / (design.dof_per_step * variance), kLeastSteps, design.steps);
  return simulated(design, kStudies);
}

/// "; about 5 runs like it would tell whether the factor 0.747 seen is real", behind why one run does not.
std::string told_by_runs(const SettlingRuns& settling) {
  if (settling.runs == 0) return {};
  return fmt::format("; about {} runs like it would tell whether the factor {} seen is real", settling.runs,
                     number_text(settling.observed_factor, 3));
}

/// Of a run that is long enough by its NEES, whose errors stay, last or oscillate all the same.
bool is_set_aside(const Evidence& e, const TimeAverageTest& average) {
  return average.effective_steps >= kShortestStretch * static_cast<double>(kTestedStretches) &&
         e.law.stretches.stand(average.effective_steps);
}

}  // namespace

double memory_in_rows(const Evidence& e) {
  const RunSums& runs = e.whole_runs;
  if (!e.joint_covariance || runs.samples.size() != runs.nees.size()) return kNaN;
  double rows_per_sample = kNaN;
  for (std::size_t i = 0; i < runs.samples.size(); ++i) {
    const Matrix& errors = runs.samples[i];
    const double rows =
        std::round(static_cast<double>(runs.nees[i].size()) / static_cast<double>(errors.cols()));
    if (errors.rows() != e.state_dim || (i > 0 && rows != rows_per_sample)) return kNaN;
    rows_per_sample = rows;
  }
  return rows_per_sample * memory_of_squares(runs.samples);
}

double effective_steps_of(const RunSums& runs, std::size_t steps) {
  constexpr std::size_t kEnough = 50;
  const auto whole = [steps](const std::vector<double>& run) { return run.size() == steps; };
  if (runs.nees.size() < kEnough || steps < 2 || !std::ranges::all_of(runs.nees, whole)) return kNaN;
  return measured_effective_steps(runs.nees);
}

SettlingRuns settle(const ConsistencyVerdict& v, bool white, double effective_steps) {
  if (v.steps_tested == 0) return {.detectable = {}, .reason = "no data"};
  const double runs = static_cast<double>(v.count) / static_cast<double>(v.steps_tested);
  return runs_to_settle(v, design_of(v, runs, white, effective_steps), runs, kSettlingPower);
}

SettlingRuns settle_few(const Evidence& e, const StudyStatistics& s, const SkewedMoments& stretches,
                        const Judgement& j) {
  SettlingRuns result = settle(j.nees, false, effective_steps_within(e.whole_runs.nees));
  const bool of_stretches = stretches.count > 0;
  // Of fewer runs a P that is too large is tested by a bound that needs more of them (run_mean.h).
  if (!of_stretches && result.observed_factor < 1.0 && result.runs > 0)
    result.runs = std::max(result.runs, StretchSums::kMostRuns + 1);
  const SkewedMoments& averages = of_stretches ? stretches : s.nees_of_runs.moments;
  if (j.nees.verdict != Verdict::consistent || averages.count < kFewestRunsCompared || !(averages.mean > 0.0))
    return result;
  const auto runs = static_cast<double>(s.nees_of_runs.moments.count);
  result.detectable = detectable_factors(design_of_units(j.nees, averages, runs),
                                         static_cast<double>(averages.count), kSettlingPower);
  if (result.runs > 0) {
    const double seen = std::log(result.observed_factor);
    result.runs = std::min(result.runs, runs_that_show(seen, result.detectable, runs));
  }
  return result;
}

void leave_open(const Evidence& e, Judgement& j) {
  ConsistencyVerdict& v = j.nees;
  v.verdict = Verdict::consistent;
  j.settle_nees = settle(v, false, j.effective_steps);
  v.verdict = Verdict::undecided;
  const bool stands = is_set_aside(e, j.single->time_average);
  const StretchSums& stretches = e.law.stretches;
  const double effective = j.single->time_average.effective_steps;
  const char* const kind = stretches.stay()            ? "that stays as it is over all"
                           : stretches.last(effective) ? "that lasts for a tenth of the"
                           : stretches.oscillate(effective)
                               ? "that oscillates and is not forgotten in a tenth of the"
                               : "of which a part stays over all";
  const auto all_rows = static_cast<std::int64_t>(e.first_run.size());
  const auto reason = [&](std::int64_t rows, double worth) {
    if (stands)
      return fmt::format("in one run an error {} {} rows cannot be told from a wrong P", kind, all_rows);
    if (rows == 1) return std::string("one row is too few to decide");
    return fmt::format("one run of {} rows is worth {} independent ones, too few to decide", rows,
                       number_text(worth, 3));
  };
  v.reason = reason(all_rows, j.effective_steps);
  const double needed = j.single->rows_needed;
  if (!stands && needed > static_cast<double>(all_rows))
    v.reason += fmt::format(": its test takes some {:.0f} rows", needed);
  v.reason += told_by_runs(j.settle_nees);
  for (BlockVerdict& block : j.blocks) {
    ConsistencyVerdict& of_block = block.verdict;
    if (of_block.verdict != Verdict::consistent) continue;
    // Errors of a block that is there for a part of the run are taken to last as long as those of the whole.
    const std::int64_t rows = std::min(all_rows, of_block.count * of_block.step_stride);
    const double worth =
        std::max(1.0, j.effective_steps * static_cast<double>(rows) / static_cast<double>(all_rows));
    const SettlingRuns settling = settle(of_block, false, worth);
    of_block.verdict = Verdict::undecided;
    of_block.reason = reason(rows, worth) + told_by_runs(settling);
  }
}

void judge_single_run(const Evidence& e, std::span<const double> nees, double memory, Judgement& j) {
  const ThinnedSeries series = thinned(nees);
  if (j.nees.verdict == Verdict::undecided || series.values.empty()) return;
  ConsistencyVerdict& v = j.nees;
  SingleRunJudgement single;
  // Two tests by the union bound, each at half the level; one of a run that has no ten stretches.
  const double tests = series.values.size() < kTestedStretches ? 1.0 : 2.0;
  const double half = 1.0 - 0.5 * (1.0 - j.confidence);
  const std::vector<TimeAverageTest> averages = test_single_run(
      series.values, {half, j.confidence, 2.0 * kSettlingPower - 1.0}, memory / series.rows_per_value);
  single.time_average = averages[0];
  // About its own mean, so that it is the same for any scale of P.
  single.sample = effective_sample(series.values);
  single.sample.correlation_time *= series.rows_per_value;
  single.rows_needed =
      static_cast<double>(kTestedStretches) * shortest_stretch(single.sample.correlation_time, memory);
  const auto rows = static_cast<double>(nees.size());
  if (!std::isnan(memory)) {
    single.sample.correlation_time = std::fmax(memory, 0.5 * single.sample.correlation_time);
    single.sample.size = rows / single.sample.correlation_time;
  } else if (single.sample.reason.empty()) {
    single.sample.size = unbiased_size(rows, single.sample.correlation_time);
  }
  const bool stand = is_set_aside(e, single.time_average);
  if (stand) single.time_average.p_value = kNaN;
  const double p_average = single.time_average.p_value;
  const bool tested = !std::isnan(p_average);
  const bool high = single.time_average.average.mean > 1.0;
  const auto joined = [&](double p, bool side) {
    return std::min(1.0, tests * (tested && side ? std::min(p, p_average) : p));
  };
  v.optimistic_p_value = joined(v.optimistic_p_value, high);
  v.pessimistic_p_value = joined(v.pessimistic_p_value, !high);
  v.p_value = std::min(v.optimistic_p_value, v.pessimistic_p_value);
  v.method += "; average over stretches of the run longer than its correlation in time";
  if (tested) ++v.tests;
  const double alpha = 1.0 - j.confidence;
  if (v.p_value > alpha) {
    v.verdict = tested ? Verdict::consistent : Verdict::undecided;
  } else {
    v.verdict = direction_of(v.optimistic_p_value <= alpha, v.pessimistic_p_value <= alpha);
  }
  j.effective_steps = stand || std::isnan(single.sample.size) ? 1.0 : single.sample.size;
  if (tested) {
    const MeanInterval& decides = averages[0].average;
    v.factor = averages[1].average;
    v.bounds = {v.mean / decides.upper, v.mean / decides.lower};
    v.bounds_p_value = p_average;
    v.decided_by_steps = v.decided_by_steps && 2.0 * v.steps_p_value < p_average;
    j.scale_covariance = scale_of_covariance(v);
    j.settle_nees = settle_stretches(v, decides, averages[2].average);
    j.single = single;
    return;
  }
  j.single = single;
  if (v.verdict == Verdict::undecided) return leave_open(e, j);
  j.settle_nees = settle(v, false, j.effective_steps);
}

}  // namespace credence::internal
