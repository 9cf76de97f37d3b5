#include "analysis/evidence/log_analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/evidence/consistency_judge.h"

namespace credence {
namespace {

/// Moments and dof of every step, as the judges want them.
struct StepSeries {
  std::vector<Moments> moments;
  std::vector<double> dof;

  void add(const Moments& m, double step_dof) {
    moments.push_back(m);
    dof.push_back(step_dof);
  }
};

StepSeries series_of(const SumsOverSteps& sums, std::size_t steps) {
  StepSeries series;
  for (const StepSums& s : sums) series.add(s.value, static_cast<double>(s.dof));
  for (std::size_t k = sums.size(); k < steps; ++k) series.add({}, 0.0);
  return series;
}

/// Blocks without their covariances: each step, too, is a sum of dependent χ².
VerdictLaws separate_block_laws(std::size_t blocks) {
  const double parts = static_cast<double>(blocks);
  VerdictLaws laws;
  laws.step = [=](double dof, double) { return dependent_law(std::vector<double>(blocks, dof / parts)); };
  laws.overall = [=](const std::vector<StepTest>& tested) {
    std::vector<double> dofs;
    for (const StepTest& step : tested) dofs.insert(dofs.end(), blocks, step.total_dof / parts);
    return dependent_law(dofs);
  };
  laws.method =
      "NEES summed over blocks whose covariances are not in the log; every step and the sum over steps by a "
      "bound for every dependence, Bonferroni over the steps";
  return laws;
}

/// At most kLongest averages of successive values: correlation times of long runs cost the square of their
/// length.
struct ThinnedSeries {
  std::vector<double> values;
  double rows_per_value = 1.0;
};

ThinnedSeries thinned(const std::vector<double>& values) {
  constexpr std::size_t kLongest = 20'000;
  const std::size_t group = (values.size() + kLongest - 1) / kLongest;
  if (group <= 1) return {values, 1.0};
  ThinnedSeries result{{}, static_cast<double>(group)};
  for (std::size_t i = 0; i + group <= values.size(); i += group) {
    double sum = 0.0;
    for (std::size_t j = i; j < i + group; ++j) sum += values[j];
    result.values.push_back(sum / static_cast<double>(group));
  }
  return result;
}

VerdictDesign single_run_design(const ConsistencyVerdict& v, double runs, double effective_steps) {
  const double steps = static_cast<double>(std::max<std::int64_t>(1, v.steps_tested));
  return {.steps = steps,
          .dof_per_step = std::max(1e-9, v.dof / (steps * runs)),
          .confidence = v.confidence,
          .white = false,
          .effective_steps = std::clamp(effective_steps, 1.0, steps)};
}

SettlingRuns settling_runs(const ConsistencyVerdict& v, double effective_steps) {
  constexpr double kPower = 0.8;
  ConsistencyVerdict assumed = v;
  if (v.verdict == Verdict::undecided) assumed.verdict = Verdict::consistent;
  return runs_to_settle(assumed, single_run_design(v, 1.0, effective_steps), 1.0, kPower);
}

/// Adds to the verdict what the course of one run in time says.
void judge_single_run(LogAnalysis& a) {
  const ThinnedSeries series = thinned(a.statistics.first_run);
  if (a.nees.verdict == Verdict::undecided || series.values.empty()) return;
  ConsistencyVerdict& v = a.nees;
  SingleRunAnalysis single;
  // Two tests by the union bound, each at half the level.
  const double half = 1.0 - 0.5 * (1.0 - a.confidence);
  single.time_average = test_single_run(series.values, half);
  single.sample = effective_sample(std::vector<std::span<const double>>{series.values}, 1.0);
  single.sample.correlation_time *= series.rows_per_value;
  const double p_average = single.time_average.p_value;
  const bool tested = !std::isnan(p_average);
  v.p_value = std::min(1.0, 2.0 * (tested ? std::min(v.p_value, p_average) : v.p_value));
  v.method += "; average over stretches of the run longer than its correlation in time";
  if (tested) ++v.tests;
  if (v.p_value > 1.0 - a.confidence) {
    v.verdict = tested ? Verdict::consistent : Verdict::undecided;
  } else if (v.verdict == Verdict::consistent) {
    v.verdict = v.mean > v.expected ? Verdict::optimistic : Verdict::pessimistic;
  }
  const double effective = std::isnan(single.sample.size) ? 1.0 : single.sample.size;
  single.settling = settling_runs(v, effective);
  if (v.verdict == Verdict::undecided) {
    v.reason = fmt::format("one run of {} rows is worth {:.3g} independent ones, too few to decide",
                           a.statistics.first_run.size(), effective);
    if (single.settling.runs > 0) {
      v.reason += fmt::format("; about {} runs like it would tell whether the factor {:.3g} seen is real",
                              single.settling.runs, single.settling.observed_factor);
    }
  }
  a.single = single;
}

SensorAnalysis analyse_sensor(const std::string& name, const SensorStatistics& s, std::size_t steps,
                              double confidence) {
  SensorAnalysis result;
  result.name = name;
  result.of_sum = !s.lags || s.varies;
  const StepSeries nis = series_of(s.nis, steps);
  result.nis = judge_nis(nis.moments, nis.dof, confidence);
  result.whiteness = test_whiteness(result.of_sum ? s.scalar_lags : *s.lags, confidence);
  result.mean = test_innovation_mean(result.of_sum ? s.scalar_mean : *s.mean);
  return result;
}

std::vector<double> step_means(const StudyStatistics& statistics, Quantity quantity, bool root) {
  std::vector<double> result;
  bool any = false;
  for (const StepStatistics& step : statistics.steps) {
    const Moments& m = step[quantity];
    any = any || m.count > 0;
    result.push_back(m.count == 0 ? std::nan("") : root ? std::sqrt(m.mean) : m.mean);
  }
  return any ? result : std::vector<double>{};
}

void judge_log_blocks(LogAnalysis& a) {
  const std::size_t steps = a.statistics.study.steps.size();
  for (const auto& [name, sums] : a.statistics.blocks) {
    const StepSeries s = series_of(sums, steps);
    ConsistencyVerdict verdict = judge_nees(s.moments, s.dof, a.confidence);
    if (name == "vehicle") a.vehicle_nees = verdict;
    a.blocks.push_back({name, std::move(verdict)});
  }
  if (a.blocks.size() < 2) a.blocks.clear();
  if (!a.blocks.empty()) a.responsible = responsible_block(a.nees, a.blocks);
}

}  // namespace

LogAnalysis analyse_logs(LogStatistics statistics, double confidence, bool sensitivity) {
  LogAnalysis a;
  a.statistics = std::move(statistics);
  a.confidence = confidence;
  const StudyStatistics& s = a.statistics.study;
  const StepSeries nees{s.series(Quantity::nees), s.dofs(Quantity::nees)};
  const StepSeries nis{s.series(Quantity::nis), s.dofs(Quantity::nis)};
  const bool joint = a.statistics.joint_covariance || a.statistics.blocks.size() < 2;
  const VerdictLaws separate = separate_block_laws(std::max<std::size_t>(1, a.statistics.blocks.size()));
  const auto judge = [&](const StepSeries& series) {
    return joint ? judge_nees(series.moments, series.dof, confidence)
                 : judge_sums(series.moments, series.dof, confidence, separate);
  };
  a.nees = judge(nees);
  a.nis = judge_nis(nis.moments, nis.dof, confidence);
  judge_log_blocks(a);
  if (s.runs == 1) judge_single_run(a);
  for (const auto& [name, sensor] : a.statistics.sensors) {
    a.sensors.push_back(analyse_sensor(name, sensor, s.steps.size(), confidence));
  }
  a.fit = test_uniform(a.statistics.nis_fit);
  if (sensitivity) {
    const StepSeries clean_nees = series_of(a.statistics.clean_nees, s.steps.size());
    const StepSeries clean_nis = series_of(a.statistics.clean_nis, s.steps.size());
    a.sensitivity = SensitivityAnalysis{.nees_outliers = a.statistics.nees_outliers,
                                        .nis_outliers = a.statistics.nis_outliers,
                                        .nees = judge(clean_nees),
                                        .nis = judge_nis(clean_nis.moments, clean_nis.dof, confidence)};
  }
  a.covariance = {.trace_prior = {},
                  .trace = step_means(s, Quantity::trace, false),
                  .vehicle = step_means(s, Quantity::trace_vehicle, false),
                  .landmarks = step_means(s, Quantity::trace_landmarks, false)};
  a.errors = {.position_m = step_means(s, Quantity::position_error_squared, true),
              .heading_rad = step_means(s, Quantity::heading_error_squared, true),
              .landmark_m = step_means(s, Quantity::landmark_error_squared, true)};
  return a;
}

Verdict overall_verdict(const LogAnalysis& a) {
  const bool has_nis = a.nis.count > 0;
  if (!a.statistics.has_truth) return a.nis.verdict;
  if (is_inconsistent(a.nees.verdict) || !has_nis) return a.nees.verdict;
  if (a.nis.verdict != Verdict::consistent) return a.nis.verdict;
  return a.nees.verdict;
}

}  // namespace credence
