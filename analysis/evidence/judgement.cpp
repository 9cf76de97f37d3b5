#include "analysis/evidence/judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "analysis/evidence/consistency_gated.h"
#include "analysis/evidence/consistency_judge.h"
#include "analysis/evidence/effective_steps.h"
#include "analysis/evidence/settling_power.h"
#include "analysis/laws/multiple_tests.h"
#include "analysis/laws/run_mean.h"
#include "analysis/laws/sample_size.h"
#include "analysis/laws/second_moments.h"
#include "analysis/laws/student.h"
#include "analysis/laws/student_positive_mean.h"
#include "analysis/laws/thinned_series.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// Moments and dof of every step, as the judges want them.
struct StepSeries {
  std::vector<Moments> moments;
  std::vector<double> dof;
};

StepSeries series_of(const SumsOverSteps& sums, std::size_t steps) {
  StepSeries series;
  series.moments.resize(std::max(steps, sums.size()));
  series.dof.resize(series.moments.size());
  for (std::size_t k = 0; k < sums.size(); ++k) {
    series.moments[k] = sums[k].value;
    series.dof[k] = static_cast<double>(sums[k].dof);
  }
  return series;
}

/// A sum over parts whose covariances are not known, blocks or sensors: each step, too, is a sum of dependent
/// χ². Their dof are taken as equal, which is the widest as the spread of χ²(n) grows like √n.
VerdictLaws separate_laws(std::size_t blocks, std::string method) {
  const double parts = static_cast<double>(blocks);
  VerdictLaws laws;
  laws.step = [=](double dof, double) { return dependent_law(std::vector<double>(blocks, dof / parts)); };
  laws.overall = [=](const std::vector<StepTest>& tested) {
    std::vector<double> dofs;
    for (const StepTest& step : tested) dofs.insert(dofs.end(), blocks, step.total_dof / parts);
    return dependent_law(dofs);
  };
  laws.method = std::move(method);
  return laws;
}

/// The verdict on the NEES of the whole state.
ConsistencyVerdict judge_state(const Evidence& e, const StepSeries& series, double confidence,
                               const RunAverages* runs = nullptr) {
  if (e.joint_covariance || e.blocks.size() < 2)
    return judge_nees(series.moments, series.dof, confidence, runs);
  VerdictLaws laws = separate_laws(
      e.blocks.size(),
      "NEES summed over blocks whose covariances are not in the log; every step and the sum over steps by a "
      "bound for every dependence, Bonferroni over the steps");
  if (runs != nullptr && runs->moments.count >= kFewestRunsCompared) laws.runs = runs;
  return judge_sums(series.moments, series.dof, confidence, laws);
}

/// Of a few long runs; empty where only whole ones are compared.
SkewedMoments stretches_of(const Evidence& e, const StudyStatistics& s) {
  const bool all = std::ssize(e.whole_runs.nees) == s.nees_of_runs.moments.count;
  return all && !e.law.stretches_stand() ? stretch_averages(e.whole_runs.nees) : SkewedMoments{};
}

/// Of the whole state in these runs; of a few long ones these averages of their stretches are compared.
ConsistencyVerdict judge_study(const Evidence& e, const StudyStatistics& s, const SkewedMoments& averages,
                               double confidence) {
  const StepSeries nees{s.series(Quantity::nees), s.dofs(Quantity::nees)};
  if (averages.count == 0) return judge_state(e, nees, confidence, &s.nees_of_runs);
  const RunAverages stretches{.moments = averages, .first = {}, .least_dof = s.nees_of_runs.least_dof};
  ConsistencyVerdict v = judge_state(e, nees, confidence, &stretches);
  v.method += fmt::format("; of {} runs their {} stretches, longer than ten correlation times each",
                          s.nees_of_runs.moments.count, stretches.moments.count);
  return v;
}

/// The verdict on the NIS of all sensors. Those of one step may have been taken against the same prior, whose
/// error they then share.
ConsistencyVerdict judge_all_sensors(const Evidence& e, const StepSeries& nis, double confidence) {
  if (e.sensors.size() < 2) return judge_nis(nis.moments, nis.dof, confidence);
  return judge_sums(nis.moments, nis.dof, confidence,
                    separate_laws(e.sensors.size(),
                                  "NIS summed over sensors that may share the error of a prior; every step "
                                  "and the sum over steps by a bound for every dependence, Bonferroni over "
                                  "the steps"));
}

/// The verdict on the NIS of one sensor.
ConsistencyVerdict judge_sensor_nis(const SensorSums& s, const std::optional<GateFound>& gate,
                                    const StepSeries& nis, double confidence) {
  if (!gate) return judge_nis(nis.moments, nis.dof, confidence);
  return judge_gated_nis(nis.moments, static_cast<double>(s.by_dimension.begin()->first), gate->nis,
                         confidence);
}

/// Each sensor's NIS has its own law, so the verdict on all is theirs together, by the union bound.
void join_sensors(const std::vector<SensorJudgement>& sensors, ConsistencyVerdict& v) {
  if (v.verdict == Verdict::undecided) return;
  double optimistic = 1.0, pessimistic = 1.0, tested = 0.0;
  for (const SensorJudgement& sensor : sensors) {
    if (sensor.nis.verdict == Verdict::undecided) continue;
    optimistic = std::min(optimistic, sensor.nis.optimistic_p_value);
    pessimistic = std::min(pessimistic, sensor.nis.pessimistic_p_value);
    tested += 1.0;
  }
  if (tested == 0.0) return;
  const double alpha = 1.0 - v.confidence;
  v.optimistic_p_value = std::min(1.0, tested * optimistic);
  v.pessimistic_p_value = std::min(1.0, tested * pessimistic);
  v.p_value = std::min(v.optimistic_p_value, v.pessimistic_p_value);
  v.verdict = direction_of(v.optimistic_p_value <= alpha, v.pessimistic_p_value <= alpha);
  v.decided_by_sensors = true;
  v.method += "; the verdict is that of the sensors one by one, Bonferroni over them";
}

void judge_verdicts(const Evidence& e, const StudyStatistics& s, const SkewedMoments& stretches,
                    Judgement& j) {
  j.nees = judge_study(e, s, stretches, j.confidence);
  j.vehicle_nees = judge_vehicle(s, j.confidence);
  const StepSeries nis{s.series(Quantity::nis), s.dofs(Quantity::nis)};
  j.nis = e.sensors.size() == 1 ? judge_sensor_nis(e.sensors[0], j.sensors[0].gate, nis, j.confidence)
                                : judge_all_sensors(e, nis, j.confidence);
  if (e.sensors.size() > 1) join_sensors(j.sensors, j.nis);
}

void judge_blocks(const Evidence& e, const JudgementContext& context, Judgement& j) {
  const std::size_t steps = e.study.steps.size();
  for (const BlockSums& block : e.blocks) {
    // A map of one landmark is that landmark.
    const bool single =
        block.part == Part::map && std::ranges::count(e.blocks, Part::landmark, &BlockSums::part) == 1;
    if (single) continue;
    const StepSeries s = series_of(block.nees, steps);
    j.blocks.push_back({block.name, judge_nees(s.moments, s.dof, j.confidence, &block.runs)});
  }
  if (j.blocks.size() < 2) j.blocks.clear();
  if (j.blocks.empty()) return;
  // Of the same runs as the blocks: all runs of a long study see what the blocks of fewer cannot.
  const bool all = context.all_runs == nullptr;
  j.responsible = responsible_block(
      all ? j.nees : judge_study(e, e.study, stretches_of(e, e.study), j.confidence), j.blocks);
}

CoverageVerdict judge_region(const CoverageSums::Region& region, double confidence) {
  std::vector<double> expected;
  for (std::size_t k = 0; k < region.count.size(); ++k) {
    const auto total = static_cast<double>(region.count[k].total);
    expected.push_back(total > 0.0 ? std::min(1.0, region.expected[k] / total) : 0.0);
  }
  return judge_coverage(region.count, expected, confidence);
}

/// A gate, where that many empty bins at the top cannot be chance and the rest fits.
std::optional<GateFound> find_gate(const SensorSums& s, double confidence) {
  constexpr double kFewest = 20.0;  // values expected beyond; none there has probability 2e-9
  if (s.by_dimension.size() != 1) return std::nullopt;
  const std::vector<std::int64_t>& counts = s.fit.counts();
  std::size_t used = counts.size();
  while (used > 0 && counts[used - 1] == 0) --used;
  const auto values = static_cast<double>(s.fit.count());
  const double expected =
      values * static_cast<double>(counts.size() - used) / static_cast<double>(counts.size());
  if (used < 2 || expected < kFewest) return std::nullopt;
  const GoodnessOfFit fit = test_uniform(UniformHistogram(std::span(counts).first(used), s.fit.invalid()));
  if (!(fit.anderson_p_value > 1.0 - confidence)) return std::nullopt;
  return GateFound{s.largest_nis, expected, fit.anderson_p_value};
}

/// Values with so few digits that their steps would be taken for another law: with n values on a grid of G
/// places, some n/G of them are equal to another, and steps of 1/G show to the test from about 0.1/√n on.
bool is_rounded(const CoverageCount& ties) {
  constexpr double kShare = 0.1;
  constexpr std::int64_t kFewest = 20;
  return ties.total >= kFewest && static_cast<double>(ties.inside) > kShare * static_cast<double>(ties.total);
}

SensorJudgement judge_sensor(const SensorSums& s, std::size_t steps, double confidence) {
  SensorJudgement result;
  result.name = s.sensor.name;
  result.of_sum = s.varies;
  const StepSeries nis = series_of(s.nis, steps);
  result.gate = find_gate(s, confidence);
  result.nis = judge_sensor_nis(s, result.gate, nis, confidence);
  result.whiteness = test_whiteness(s.varies ? s.scalar_lags : s.lags, confidence);
  const VectorMoments& means = s.varies ? s.scalar_run_means : s.run_means;
  const bool enough_runs = means.count > 0 && means.count > means.mean.size() + 1;
  if (s.sensor.nis_alone) {
    result.mean = {.p_value = kNaN, .reason = "NIS alone has no sign"};
    result.mean.chi_square_p_value = kNaN;
  } else {
    result.mean = test_zero_mean(enough_runs ? means : s.varies ? s.scalar_values : s.values);
  }
  result.fit = test_uniform(s.fit);
  if (is_rounded(s.ties)) {
    result.fit.kolmogorov_p_value = result.fit.anderson_p_value = kNaN;
    result.fit.reason = "not tested: the values are rounded, as many are equal to another";
  }
  result.histogram = s.fit.counts();
  return result;
}

/// NaN unless there are enough whole runs of one length for a correlation in time.
double effective_steps_of(const RunSums& runs, std::size_t steps) {
  constexpr std::size_t kEnough = 50;
  const auto whole = [steps](const std::vector<double>& run) { return run.size() == steps; };
  if (runs.nees.size() < kEnough || steps < 2 || !std::ranges::all_of(runs.nees, whole)) return kNaN;
  return measured_effective_steps(runs.nees);
}

VerdictDesign design_of(const ConsistencyVerdict& v, double runs, bool white, double effective_steps) {
  const auto steps = static_cast<double>(std::max<std::int64_t>(1, v.steps_tested));
  const double effective = std::isfinite(effective_steps) ? std::clamp(effective_steps, 1.0, steps) : 1.0;
  return {.steps = steps,
          .dof_per_step = std::max(1e-9, v.dof / (steps * runs)),
          .confidence = v.confidence,
          .white = white,
          .effective_steps = white ? steps : effective};
}

SettlingRuns settle(const ConsistencyVerdict& v, bool white, double effective_steps) {
  if (v.steps_tested == 0) return {.detectable = {}, .reason = "no data"};
  const double runs = static_cast<double>(v.count) / static_cast<double>(v.steps_tested);
  return runs_to_settle(v, design_of(v, runs, white, effective_steps), runs, kSettlingPower);
}

void judge_scales(const Evidence& e, Judgement& j) {
  j.scale_covariance = scale_of_covariance(j.nees);
  const double alpha = 1.0 - j.confidence;
  const auto shared = [alpha](const SensorPairJudgement& p) { return p.correlation.p_value <= alpha; };
  j.scale_innovation = std::ranges::any_of(j.law.sensor_pairs, shared)
                           ? no_scale("sensors of the same step are correlated")
                           : scale_of_innovation(j.nis);
  Moments share;
  for (const SensorSums& sensor : e.sensors) share.merge(sensor.measurement_share);
  j.scale_measurement_noise = share.count > 0 && share.mean > 0.0
                                  ? scale_of_measurement_noise(j.scale_innovation, std::min(1.0, share.mean))
                                  : no_scale(share.count > 0 ? "R is zero" : "R is not known");
}

void judge_ends(const Evidence& e, Judgement& j) {
  const RunSums& runs = e.whole_runs;
  const Index n = runs.last_error.empty() ? 0 : runs.last_error.front().size();
  const auto same = [n](const Vector& error) { return error.size() == n; };
  const bool enough = std::ssize(runs.last_error) > n && std::ranges::all_of(runs.last_error, same);
  j.credibility = n > 0 && enough
                      ? credibility_index(runs.last_error, runs.last_covariance, j.confidence)
                      : CredibilityIndex{.reason = "fewer whole runs than the vehicle has dimensions"};
  j.error_correlation = test_error_correlation(runs.last_whitened);
  j.position = j.heading = j.landmark = rmse_interval({}, j.confidence);
  for (const BlockSums& block : e.blocks) {
    if (block.part == Part::other || block.part == Part::pose || block.part == Part::landmark) continue;
    RmseInterval& rmse = block.part == Part::position  ? j.position
                         : block.part == Part::heading ? j.heading
                                                       : j.landmark;
    rmse = rmse_interval(block.squared_error, j.confidence);
  }
  j.accuracy = block_accuracy(e, j.confidence);
}

/// By what factors P may be wrong for the averages of stretches or runs, whose mean at the level of the
/// verdict is `decides`, to show it with kSettlingPower: the mean is as far below that factor as it is in one
/// of 1 − kSettlingPower. Runs like these tell more by the root of their number.
SettlingRuns settle_averages(const ConsistencyVerdict& v, const MeanInterval& decides,
                             const MeanInterval& spread, double runs) {
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
    const double ratio = std::log(seen > 0.0 ? result.detectable.above : result.detectable.below) / seen;
    result.runs = static_cast<std::int64_t>(std::ceil(std::min(runs * ratio * ratio, 1e15)));
  }
  return result;
}

/// Of runs whose number of independent steps is not known: the steps alone tell something, and so do the
/// averages as far as they scatter.
SettlingRuns settle_unknown(const StudyStatistics& s, const SkewedMoments& stretches, const Judgement& j) {
  SettlingRuns result = settle(j.nees, false, kNaN);
  const SkewedMoments& averages = stretches.count > 0 ? stretches : s.nees_of_runs.moments;
  if (j.nees.verdict != Verdict::consistent || averages.count < kFewestRunsCompared) return result;
  const Moments plain{.count = averages.count, .mean = averages.mean, .m2 = averages.m2};
  const SettlingRuns by_mean = settle_averages(
      j.nees,
      run_mean_interval(averages, 0.5 * (1.0 + j.confidence), static_cast<double>(s.nees_of_runs.least_dof)),
      positive_mean_interval(plain, 2.0 * kSettlingPower - 1.0),
      static_cast<double>(s.nees_of_runs.moments.count));
  if (by_mean.detectable.above > 1.0)
    result.detectable.above = std::min(result.detectable.above, by_mean.detectable.above);
  if (by_mean.detectable.below < 1.0)
    result.detectable.below = std::max(result.detectable.below, by_mean.detectable.below);
  if (by_mean.runs > 0) result.runs = std::min(result.runs, by_mean.runs);
  return result;
}

/// Leaves one run open, whose average is not tested, and says how many like it would tell.
void leave_open(const Evidence& e, Judgement& j) {
  ConsistencyVerdict& v = j.nees;
  v.verdict = Verdict::consistent;
  j.settle_nees = settle(v, false, j.effective_steps);
  v.verdict = Verdict::undecided;
  const bool stands = j.single->time_average.run_sum.reason.empty();  // a test that was set aside
  v.reason = stands ? fmt::format("in one run an error that {} cannot be told from a wrong P",
                                  e.law.errors_stand()
                                      ? fmt::format("stays as it is over all {} rows", e.first_run.size())
                                      : fmt::format("lasts for a tenth of the {} rows", e.first_run.size()))
                    : fmt::format("one run of {} rows is worth {:.3g} independent ones, too few to decide",
                                  e.first_run.size(), j.effective_steps);
  if (j.settle_nees.runs > 0) {
    v.reason += fmt::format("; about {} runs like it would tell whether the factor {:.3g} seen is real",
                            j.settle_nees.runs, j.settle_nees.observed_factor);
  }
}

/// Adds to the verdict what the course of one run in time says.
void judge_single_run(const Evidence& e, Judgement& j) {
  const ThinnedSeries series = thinned(e.first_run);
  if (j.nees.verdict == Verdict::undecided || series.values.empty()) return;
  ConsistencyVerdict& v = j.nees;
  SingleRunJudgement single;
  // Two tests by the union bound, each at half the level.
  const double half = 1.0 - 0.5 * (1.0 - j.confidence);
  const std::vector<TimeAverageTest> averages =
      test_single_run(series.values, {half, j.confidence, 2.0 * kSettlingPower - 1.0});
  single.time_average = averages[0];
  single.sample = effective_sample(std::vector<std::span<const double>>{series.values}, 1.0);
  single.sample.correlation_time *= series.rows_per_value;
  const bool stand = !std::isnan(single.time_average.p_value) && e.law.stretches_stand();
  if (stand) single.time_average.p_value = kNaN;
  const double p_average = single.time_average.p_value;
  const bool tested = !std::isnan(p_average);
  const bool high = single.time_average.run_sum.mean > single.time_average.expected;
  const auto joined = [&](double p, bool side) {
    return std::min(1.0, 2.0 * (tested && side ? std::min(p, p_average) : p));
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
    const MeanInterval& decides = averages[0].run_sum;
    v.factor = averages[1].run_sum;
    v.bounds = {v.mean / decides.upper, v.mean / decides.lower};
    v.decided_by_steps = v.decided_by_steps && 2.0 * v.steps_p_value < p_average;
    j.scale_covariance = scale_of_covariance(v);
    j.settle_nees = settle_averages(v, decides, averages[2].run_sum, 1.0);
    j.single = single;
    return;
  }
  j.single = single;
  if (v.verdict == Verdict::undecided) return leave_open(e, j);
  j.settle_nees = settle(v, false, j.effective_steps);
}

NamedTest verdict_test(std::string name, const ConsistencyVerdict& v) {
  if (v.verdict == Verdict::undecided)
    return {std::move(name), Exactness::conservative, kNaN, kNaN, v.reason};
  return {std::move(name), Exactness::conservative, v.p_value, kNaN,
          fmt::format("mean {:.4g}, expected {:.4g}, {} tests", v.mean, v.expected, v.tests)};
}

/// A test with a reason where it was not made.
NamedTest reasoned_test(std::string name, Exactness exactness, std::string_view reason, double p_value,
                        std::string says) {
  if (!reason.empty()) return {std::move(name), exactness, kNaN, kNaN, std::string(reason)};
  return {std::move(name), exactness, p_value, kNaN, std::move(says)};
}

constexpr const char* kNisBody = "NIS against its law, body";
constexpr const char* kNisTails = "NIS against its law, tails";
constexpr const char* kWhiteness = "whiteness of the innovation";
constexpr const char* kInnovationMean = "mean of the innovation";
constexpr const char* kErrorMean = "mean of the errors";
constexpr const char* kErrorCorrelation = "correlation of the whitened errors";
constexpr const char* kHeavyTails = "tails of NEES and NIS, over runs";

/// The name of a test of two sensors.
std::string pair_test(const SensorPairJudgement& pair) {
  return fmt::format("innovations of {} and {} at one step", pair.first, pair.second);
}

/// The name of a test of one sensor.
std::string of_sensor(const char* test, const SensorJudgement& sensor) {
  return sensor.name.empty() ? test : fmt::format("{} of {}", test, sensor.name);
}

void list_sensor(const SensorJudgement& s, bool alone, std::vector<NamedTest>& tests) {
  if (!alone) tests.push_back(verdict_test("NIS of " + s.name, s.nis));
  tests.push_back(reasoned_test(
      of_sensor(kNisBody, s), Exactness::conservative, s.fit.reason, s.fit.kolmogorov_p_value,
      fmt::format("Kolmogorov-Smirnov D = {:.3g} of {} values", s.fit.kolmogorov, s.fit.count)));
  tests.push_back(reasoned_test(of_sensor(kNisTails, s), Exactness::approximate, s.fit.reason,
                                s.fit.anderson_p_value,
                                fmt::format("Anderson-Darling A² = {:.3g}", s.fit.anderson)));
  tests.push_back(
      reasoned_test(of_sensor(kWhiteness, s), Exactness::approximate, s.whiteness.reason, s.whiteness.p_value,
                    fmt::format("portmanteau Q = {:.4g}, dof {:g}", s.whiteness.statistic, s.whiteness.dof)));
  const double largest = s.mean.mean.size() > 0 ? s.mean.mean.cwiseAbs().maxCoeff() : 0.0;
  tests.push_back(reasoned_test(of_sensor(kInnovationMean, s), Exactness::exact, s.mean.reason,
                                s.mean.p_value, fmt::format("largest {:.3g} σ", largest)));
}

/// The p-values of those tests of tails that were made.
std::string tails_say(const GaussianityJudgement& g) {
  const std::pair<const char*, double> made[] = {
      {"NEES", g.nees_tail_p_value}, {"NIS", g.nis_tail_p_value}, {"NIS far out", g.far_nis_p_value}};
  std::string text;
  for (const auto& [name, p_value] : made) {
    if (!std::isnan(p_value)) text += fmt::format("{}{} p = {:.3g}", text.empty() ? "" : ", ", name, p_value);
  }
  return text;
}

void list_law(const LawJudgement& law, bool has_truth, std::vector<NamedTest>& tests) {
  for (const SensorPairJudgement& pair : law.sensor_pairs) {
    tests.push_back(reasoned_test(
        pair_test(pair), Exactness::approximate, pair.correlation.reason, pair.correlation.p_value,
        fmt::format("largest {:.3g} of {} steps", pair.correlation.largest, pair.correlation.values)));
  }
  const GaussianityJudgement& g = law.gaussianity;
  tests.push_back(reasoned_test(kHeavyTails, Exactness::conservative,
                                std::isnan(g.tail_p_value) ? "fewer than ten runs" : "", g.tail_p_value,
                                tails_say(g)));
  if (!has_truth) return;
  const SecondMomentTest& second = law.second_moments.test;
  tests.push_back(
      reasoned_test("second moments of the errors", Exactness::approximate, second.reason,
                    std::min(second.p_value.optimistic, second.p_value.pessimistic),
                    fmt::format("times {:.3g} ({:.3g} … {:.3g}) in the direction of {}", second.worst.mean,
                                second.worst.lower, second.worst.upper, law.second_moments.worst)));
  const ZeroMeanTest& mean = law.error_mean.test;
  tests.push_back(reasoned_test(
      kErrorMean, Exactness::exact, mean.reason, mean.p_value,
      mean.mean.size() > 0
          ? fmt::format("largest {:.3g} σ, of {}", mean.mean.cwiseAbs().maxCoeff(), law.error_mean.largest)
          : ""));
  const ShapeJudgement& shape = law.shape;
  const auto factor = [&](Index i) {
    const Vector& all = shape.shape.factors;
    return all.size() > 0 ? all[i < 0 ? all.size() - 1 : i] : kNaN;
  };
  tests.push_back(reasoned_test("shape of P", Exactness::approximate, shape.reason, shape.p_value,
                                fmt::format("factors {:.3g} to {:.3g} over the directions at step {}",
                                            factor(0), factor(-1), shape.step)));
}

void list_errors(const Judgement& j, std::vector<NamedTest>& tests) {
  for (std::size_t i = 0; i < j.coverage.size(); ++i) {
    const CoverageVerdict& c = j.coverage[i];
    if (c.tests == 0) continue;
    const double share = static_cast<double>(c.pooled.inside) / static_cast<double>(c.pooled.total);
    tests.push_back({fmt::format("coverage of {:g}σ", CoverageSums::kSigmas[i]), Exactness::conservative,
                     c.p_value, kNaN,
                     fmt::format("{:.4g} % inside, {:.4g} % expected", 100.0 * share, 100.0 * c.expected)});
  }
  tests.push_back(reasoned_test(
      "credibility of the vehicle's P", Exactness::approximate, j.credibility.reason, j.credibility.p_value,
      fmt::format("inclination {:.3g} dB at the last step, noncredibility {:.3g} dB",
                  j.credibility.inclination, j.credibility.noncredibility)));
  tests.push_back(reasoned_test(kErrorCorrelation, Exactness::approximate, j.error_correlation.reason,
                                j.error_correlation.p_value,
                                fmt::format("largest {:.3g} at the last step, dof {:g}",
                                            j.error_correlation.largest, j.error_correlation.dof)));
}

std::vector<NamedTest> list_tests(const Evidence& e, const Judgement& j) {
  std::vector<NamedTest> tests;
  if (e.has_truth) tests.push_back(verdict_test("NEES", j.nees));
  tests.push_back(verdict_test("NIS", j.nis));
  for (const BlockVerdict& block : j.blocks)
    tests.push_back(verdict_test("NEES of " + block.name, block.verdict));
  for (const SensorJudgement& sensor : j.sensors) list_sensor(sensor, j.sensors.size() == 1, tests);
  if (e.has_truth) list_errors(j, tests);
  list_law(j.law, e.has_truth, tests);
  std::vector<double> p_values;
  p_values.reserve(tests.size());
  for (const NamedTest& test : tests) p_values.push_back(test.p_value);
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < tests.size(); ++i) tests[i].adjusted = adjusted[i];
  return tests;
}

/// Whether a test speaks against the filter when the whole suite is taken together; a cause named for less
/// would be a guess.
bool speaks(const Judgement& j, std::string_view name) {
  const auto test = std::ranges::find(j.tests, name, &NamedTest::name);
  return test != j.tests.end() && test->adjusted <= 1.0 - j.confidence;
}

/// What speaks of one sensor.
void add_sensor_findings(const SensorSums& sums, const SensorJudgement& s, const Judgement& j, Findings& f) {
  // A correlation of NIS does not tell by its sign what causes it.
  const bool not_white = !sums.sensor.nis_alone && speaks(j, of_sensor(kWhiteness, s));
  if (not_white || (!f.whiteness && !sums.sensor.nis_alone)) f.whiteness = s.whiteness;
  f.not_white = f.not_white || not_white;
  if (speaks(j, of_sensor(kInnovationMean, s))) f.innovation_mean = s.mean;
  if (s.gate) f.gate = s.gate;
  if (!speaks(j, of_sensor(kNisBody, s)) && !speaks(j, of_sensor(kNisTails, s))) return;
  f.fit = s.fit;
  f.far_tail = sums.far_tail;
}

/// A verdict that the word has taken back when it joined all says nothing of a cause.
void take_back(const Word& word, ConsistencyVerdict& verdict) {
  if (!is_inconsistent(word.verdict) && is_inconsistent(verdict.verdict))
    verdict.verdict = Verdict::consistent;
}

Findings::GrossOutliers gross_outliers_of(const Evidence& e) {
  Findings::GrossOutliers gross;
  std::int64_t early = 0, all = 0;
  const std::size_t steps = e.study.steps.size();
  for (std::size_t k = 0; k < steps; ++k) {
    const std::int64_t values = e.study.steps[k][Quantity::nis].count;
    const std::int64_t clean = k < e.clean_nis.size() ? e.clean_nis[k].value.count : 0;
    all += values;
    gross.all += values - clean;
    if (k < steps / 5) {
      early += values;
      gross.early += values - clean;
    } else if (k >= steps / 2) {
      gross.late.merge({.inside = clean, .total = values});
    }
  }
  gross.early_share = all > 0 ? static_cast<double>(early) / static_cast<double>(all) : 0.0;
  return gross;
}

/// Of the step before the first innovation of any run; empty where the first step has one, or of a map, whose
/// landmarks begin with measurements that make no innovation.
Moments nees_before_innovations(const Evidence& e) {
  const auto& steps = e.study.steps;
  const auto first =
      std::ranges::find_if(steps, [](const StepStatistics& step) { return step[Quantity::nis].count > 0; });
  const bool of_map = std::ranges::any_of(
      e.blocks, [](const BlockSums& b) { return b.part == Part::landmark || b.part == Part::map; });
  if (of_map || first == steps.begin() || first == steps.end()) return {};
  return (*std::prev(first))[Quantity::nees];
}

void add_growth(const Evidence& e, Findings& f) {
  const auto& steps = e.study.steps;
  if (e.step_stride > 1) return;
  const auto speaks_at = [](const StepStatistics& step) { return step[Quantity::nis].count > 0; };
  const auto before = static_cast<std::size_t>(std::ranges::find_if(steps, speaks_at) - steps.begin());
  for (const std::vector<double>& nees : e.whole_runs.nees) {
    if (nees.size() != steps.size()) continue;
    double without = 0.0, with = 0.0;
    for (std::size_t k = 1; k < nees.size(); ++k) {
      (speaks_at(steps[k]) ? with : without) += nees[k] - nees[k - 1];
      if (k + 1 == before) f.growth_before_innovations.add(without);
    }
    f.growth_without_innovations.add(without);
    f.growth_with_innovations.add(with);
  }
}

/// Of each state of the layout, how many of those before it P claims to be uncorrelated with its block, at
/// every step of every run: there u = L⁻¹ e, P = L Lᵀ, has of the block the errors of it alone, |u|² its
/// NEES.
std::vector<Index> claimed_uncorrelated(const Evidence& e) {
  constexpr double kRounding = 1e-9;
  const std::vector<SkewedMoments>& along = e.law.second_moments.along();
  std::vector<Index> before(e.layout.states.size(), 0);
  for (const Block& block : e.layout.blocks) {
    const auto sums = std::ranges::find(e.blocks, block.name, &BlockSums::name);
    if (sums == e.blocks.end() || block.states.empty()) continue;
    const double nees = static_cast<double>(block.states.size()) * sums->runs.moments.mean;
    double whitened = 0.0;  // along e_p, which is the direction p²
    for (const Index p : block.states) whitened += along[static_cast<std::size_t>(p * p)].mean;
    if (!(std::abs(whitened - nees) <= kRounding * nees)) continue;
    const Index first = std::ranges::min(block.states);
    for (const Index p : block.states) {
      Index& count = before[static_cast<std::size_t>(p)];
      count = std::max(count, first);
    }
  }
  return before;
}

/// Whether errors that P claims to be uncorrelated are, over all steps of the runs: of A_pq, the average of
/// u_p u_q over a run, which is half the difference of those along (e_p ± e_q)/√2. These two do not vary
/// against each other where u_p and u_q are independent, so that their variances add up to one that is no
/// less; Student's t, Bonferroni over the pairs. None where P claims no such thing; a reason for a state too
/// large for A, or too few runs.
std::optional<ErrorCorrelationTest> test_claimed_uncorrelated(const Evidence& e) {
  constexpr std::int64_t kFewestRuns = 10;
  const SecondMoments& second = e.law.second_moments;
  if (!e.joint_covariance || std::ssize(e.layout.states) < 2) return std::nullopt;
  ErrorCorrelationTest result{.runs = second.runs(), .p_value = 1.0};
  if (std::ssize(e.layout.states) > LawSums::kLargestAveraged) result.reason = "more than 12 states";
  if (second.runs() < kFewestRuns) result.reason = "fewer than 10 runs";
  if (!result.reason.empty()) {
    result.p_value = kNaN;
    return result;
  }
  if (!e.law.averaged.empty() || second.dim() != std::ssize(e.layout.states)) return std::nullopt;
  const std::vector<Index> before = claimed_uncorrelated(e);
  const std::vector<SecondMomentDirection> directions = second_moment_directions(second.dim());
  const auto runs = static_cast<double>(second.runs());
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const auto& [p, q, sign] = directions[i];
    if (sign <= 0 || q >= before[static_cast<std::size_t>(p)]) continue;
    const SkewedMoments &sum = second.along()[i], &difference = second.along()[i + 1];
    const double covariance = 0.5 * (sum.mean - difference.mean);
    const double variance = 0.25 * (sum.m2 + difference.m2) / (runs - 1.0);
    if (!(variance > 0.0)) continue;
    const double squares = second.along()[static_cast<std::size_t>(p * p)].mean *
                           second.along()[static_cast<std::size_t>(q * q)].mean;
    result.dof += 1.0;
    result.largest = std::max(result.largest, std::abs(covariance) / std::sqrt(squares));
    const double t = covariance / std::sqrt(variance / runs);
    result.p_value = std::min(result.p_value, student_two_sided_p_value(t, runs - 1.0));
  }
  if (result.dof == 0.0) return std::nullopt;
  result.p_value = std::min(1.0, result.dof * result.p_value);
  return result;
}

std::vector<CauseFound> causes_of(const Evidence& e, const Judgement& j) {
  Findings findings{.nees = j.nees, .nis = j.nis};
  take_back(j.word, findings.nees);
  take_back(j.word, findings.nis);
  findings.inflated = e.layout.inflated;
  Moments share;
  for (std::size_t i = 0; i < j.sensors.size(); ++i) {
    add_sensor_findings(e.sensors[i], j.sensors[i], j, findings);
    findings.unwrapped_innovations += e.sensors[i].unwrapped;
    share.merge(e.sensors[i].measurement_share);
  }
  findings.far_tail_probability = SensorSums::kFarTail;
  findings.gross_outliers = gross_outliers_of(e);
  if (findings.far_tail && findings.gross_outliers.all > 0) {  // which only outliers are told by
    const StepSeries clean = series_of(e.clean_nis, e.study.steps.size());
    findings.gross_outliers.rest_fits =
        judge_all_sensors(e, clean, j.confidence).verdict == Verdict::consistent;
  }
  findings.narrow_angles = e.narrow_angles;
  if (speaks(j, kErrorMean)) findings.error_mean = {j.law.error_mean.test, j.law.error_mean.largest};
  findings.mean_at_steps = test_mean_at_steps(e.law.whitened);
  findings.block = j.responsible;
  findings.error_correlation = test_claimed_uncorrelated(e);
  findings.nees_values = e.whole_runs.nees_values;
  findings.nees_before_innovations = nees_before_innovations(e);
  add_growth(e, findings);
  findings.nonlinear = e.layout.nonlinear;
  findings.lateness = test_lateness(e.lateness);
  if (share.count > 0) findings.measurement_noise_share = share.mean;
  for (const SensorPairJudgement& pair : j.law.sensor_pairs) {
    if (!speaks(j, pair_test(pair))) continue;
    findings.sensor_pairs.push_back({pair.first, pair.second, pair.correlation});
  }
  const GaussianityJudgement& g = j.law.gaussianity;
  if (speaks(j, kHeavyTails) && g.right_but_heavy_tailed(1.0 - j.confidence)) {
    findings.heavy_tail_p_value = g.tail_p_value;
  }
  return find_causes(findings);
}

void judge_sensitivity(const Evidence& e, Judgement& j) {
  const StepSeries nees = series_of(e.clean_nees, e.study.steps.size());
  const StepSeries nis = series_of(e.clean_nis, e.study.steps.size());
  j.sensitivity = SensitivityJudgement{.nees_outliers = e.nees_outliers,
                                       .nis_outliers = e.nis_outliers,
                                       .nees = judge_state(e, nees, j.confidence),
                                       .nis = judge_all_sensors(e, nis, j.confidence)};
}

/// Which steps of the runs the steps judged are.
void name_steps(const Evidence& e, bool of_state, Judgement& j) {
  j.step_stride = e.step_stride;
  for (BlockVerdict& block : j.blocks) block.verdict.step_stride = e.step_stride;
  for (SensorJudgement& sensor : j.sensors) sensor.nis.step_stride = e.step_stride;
  if (!of_state) return;
  j.nees.step_stride = j.nis.step_stride = e.step_stride;
  if (j.vehicle_nees) j.vehicle_nees->step_stride = e.step_stride;
}

/// NEES, NIS of each sensor, the blocks, and the directions of P.
Word word_of(const Evidence& e, const Judgement& j) {
  constexpr double kDirections = 0.1;
  std::vector<WordPart> parts = word_parts(j.nees, j.nis, j.blocks);
  if (j.sensors.size() > 1) {
    const double each = parts[1].weight / static_cast<double>(j.sensors.size());
    parts.erase(parts.begin() + 1);
    for (const SensorJudgement& s : j.sensors)
      parts.push_back({"NIS of " + s.name, &s.nis, each, false, true});
  }
  ConsistencyVerdict directions;
  const SecondMomentJudgement& second = j.law.second_moments;
  if (second.test.reason.empty()) {
    directions.optimistic_p_value = second.test.p_value.optimistic;
    directions.pessimistic_p_value = second.test.p_value.pessimistic;
    directions.steps_tested = std::ssize(e.study.steps);
    directions.count = second.test.runs;
    directions.verdict = Verdict::consistent;
    parts.push_back({"the direction of " + second.worst, &directions, kDirections, true});
  }
  Word word = join_verdicts(parts, j.confidence);
  if (is_inconsistent(word.verdict) && j.law.gaussianity.right_but_heavy_tailed(1.0 - j.confidence)) {
    word.verdict = Verdict::not_gaussian;
    word.says = "the covariance is right, the errors are not Gaussian (heavy tails)";
  }
  return word;
}

}  // namespace

Judgement judge(const Evidence& e, const JudgementContext& context) {
  Judgement j;
  j.runs = e.study.runs;
  j.confidence = context.confidence;
  for (const SensorSums& sensor : e.sensors) {
    j.sensors.push_back(judge_sensor(sensor, e.study.steps.size(), j.confidence));
  }
  const StudyStatistics& all = context.all_runs != nullptr ? *context.all_runs : e.study;
  const SkewedMoments stretches = stretches_of(e, all);
  judge_verdicts(e, all, stretches, j);
  judge_blocks(e, context, j);
  name_steps(e, context.all_runs == nullptr, j);
  for (std::size_t i = 0; i < j.coverage.size(); ++i) {
    j.coverage[i] = judge_region(e.coverage.regions[i], j.confidence);
  }
  judge_ends(e, j);
  j.law = judge_law(e, all, j.confidence, context.margin);
  j.effective_steps = effective_steps_of(e.whole_runs, e.study.steps.size());
  judge_scales(e, j);
  j.settle_nees = std::isnan(j.effective_steps) ? settle_unknown(all, stretches, j)
                                                : settle(j.nees, false, j.effective_steps);
  j.settle_nis = settle(j.nis, true, j.effective_steps);
  if (e.study.runs == 1 && (context.all_runs == nullptr || context.all_runs->runs == 1))
    judge_single_run(e, j);
  j.word = word_of(e, j);
  if (j.single && std::isnan(j.single->time_average.p_value) && j.word.verdict == Verdict::consistent) {
    leave_open(e, j);  // a step that alone rejects is no reason to call it consistent
    j.word = word_of(e, j);
  }
  if (!is_inconsistent(j.word.verdict)) j.responsible = {};
  j.tests = list_tests(e, j);
  j.causes = causes_of(e, j);
  if (context.sensitivity) judge_sensitivity(e, j);
  return j;
}

std::string_view to_string(Exactness exactness) {
  switch (exactness) {
    case Exactness::exact:
      return "exact";
    case Exactness::approximate:
      return "approximate";
    case Exactness::conservative:
      return "conservative";
  }
  return "unknown";
}

std::optional<ConsistencyVerdict> judge_vehicle(const StudyStatistics& s, double confidence) {
  constexpr double kPoseDof = 3.0;
  if (s.vehicle_nees_of_runs.moments.count == 0) return std::nullopt;
  const std::vector<Moments> pose = s.series(Quantity::vehicle_nees);
  std::vector<double> dof;
  dof.reserve(pose.size());
  for (const Moments& m : pose) dof.push_back(kPoseDof * static_cast<double>(m.count));
  return judge_nees(pose, dof, confidence, &s.vehicle_nees_of_runs);
}

}  // namespace credence::internal
