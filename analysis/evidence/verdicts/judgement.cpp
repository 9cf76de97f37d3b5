#include "analysis/evidence/verdicts/judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "analysis/evidence/causes/cause_findings.h"
#include "analysis/evidence/causes/lone_outliers.h"
#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/evidence/verdicts/judgement_settling.h"
#include "analysis/evidence/verdicts/judgement_tests.h"
#include "analysis/evidence/verdicts/judgement_word.h"
#include "analysis/evidence/verdicts/sensor_judgement.h"
#include "analysis/evidence/verdicts/series_verdicts.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "core/enum_words.h"
#include "core/nan.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

/// Of a few long runs; empty where only whole ones are compared.
StretchAverages stretches_of(const Evidence& e, std::span<const std::vector<double>> nees, double memory) {
  StretchAverages stretches = stretch_averages(nees, memory);
  const bool stand = stretches.averages.count > 0 && e.law.stretches.stand(stretches.effective_rows);
  return stand ? StretchAverages{} : stretches;
}
StretchAverages stretches_of(const Evidence& e, const StudyStatistics& s, double memory) {
  const bool all = std::ssize(e.whole_runs.nees) == s.nees_of_runs.moments.count;
  return all ? stretches_of(e, e.whole_runs.nees, memory) : StretchAverages{};
}

/// Of the blocks of few runs where those of the whole state are: no error stays then.
std::vector<SkewedMoments> block_stretches_of(const Evidence& e, const StretchAverages& state) {
  std::vector<SkewedMoments> averages;
  for (std::size_t b = 0; state.averages.count > 0 && b < e.blocks.size(); ++b) {
    const BlockSums& block = e.blocks[b];
    const bool all = std::ssize(block.few) == block.runs.moments.count;
    averages.push_back(all ? stretch_averages(averages_alike(block.few)).averages : SkewedMoments{});
  }
  return averages;
}

/// One run has a test of its own (judge_single_run).
SkewedMoments averages_compared(const Evidence& e, const StretchAverages& stretches) {
  return e.whole_runs.nees.size() > 1 ? stretches.averages : SkewedMoments{};
}

/// What `judge` says of these runs; of a few long ones the averages of their stretches are compared.
template <class Judge>
ConsistencyVerdict judge_runs(const RunAverages& runs, const SkewedMoments& averages, const Judge& judge) {
  if (averages.count == 0) return judge(runs);
  ConsistencyVerdict v = judge(RunAverages{.moments = averages, .first = {}, .least_dof = runs.least_dof});
  const std::int64_t count = runs.moments.count;
  v.method += fmt::format("; of {} {} stretches, longer than seven correlation times each",
                          count == 1 ? "the run its" : fmt::format("{} runs their", count), averages.count);
  return v;
}

/// Of the whole state.
ConsistencyVerdict judge_study(const Evidence& e, const StudyStatistics& s, const SkewedMoments& averages,
                               double confidence) {
  const StepSeries nees{s.series(Quantity::nees), s.dofs(Quantity::nees)};
  return judge_runs(s.nees_of_runs, averages,
                    [&](const RunAverages& runs) { return judge_state(e, nees, confidence, &runs); });
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
  j.nis = e.sensors.size() == 1
              ? judge_sensor_nis(e.sensors[0], j.sensors[0].gate, j.sensors[0].correlation, nis, j.confidence)
              : judge_all_sensors(e, nis, j.confidence);
  if (e.sensors.size() > 1) join_sensors(j.sensors, j.nis);
}

void judge_blocks(const Evidence& e, const JudgementContext& context, const FewRuns& few, Judgement& j) {
  for (std::size_t b = 0; b < e.blocks.size(); ++b) {
    const BlockSums& block = e.blocks[b];
    // A map of one landmark is that landmark.
    const bool single =
        block.part == Part::map && std::ranges::count(e.blocks, Part::landmark, &BlockSums::part) == 1;
    if (single) continue;
    const StepSeries s = series_of(block.nees, e.study.steps.size());
    j.blocks.push_back({block.name, judge_runs(block.runs, few.block(b), [&](const RunAverages& runs) {
                          return judge_nees(s.moments, s.dof, j.confidence, &runs);
                        })});
  }
  if (j.blocks.size() < 2) j.blocks.clear();
  if (j.blocks.empty()) return;
  // Of the same runs as the blocks: all runs of a long study see what the blocks of fewer cannot.
  const bool all = context.all_runs == nullptr;
  j.responsible = responsible_block(
      all ? j.nees
          : judge_study(e, e.study, averages_compared(e, stretches_of(e, e.study, few.memory)), j.confidence),
      j.blocks);
}

CoverageVerdict judge_region(const CoverageSums::Region& region, double confidence) {
  std::vector<double> expected;
  for (std::size_t k = 0; k < region.count.size(); ++k) {
    const auto total = static_cast<double>(region.count[k].total);
    expected.push_back(total > 0.0 ? std::min(1.0, region.expected[k] / total) : 0.0);
  }
  return judge_coverage(region.count, expected, confidence);
}

/// Of the sensor whose innovations are correlated for longest.
SquareCorrelation longest_correlation(const Judgement& j) {
  SquareCorrelation longest;
  for (const SensorJudgement& sensor : j.sensors) {
    longest.of_sum = std::max(longest.of_sum, sensor.correlation.of_sum);
    longest.known = longest.known && sensor.correlation.known;
  }
  return longest;
}

/// The factor on S.
ScaleAdvice scale_of_sensors(const Judgement& j) {
  const SquareCorrelation correlation = longest_correlation(j);
  if (correlation.known) return scale_of_innovation(j.nis, correlation.of_sum);
  if (!j.nis.factor.reason.empty()) return no_scale(kLasting);
  return {
      .factor = j.nis.factor.mean, .lower = j.nis.factor.lower, .upper = j.nis.factor.upper, .reason = {}};
}

void judge_scales(const Evidence& e, const JudgementContext& context, Judgement& j) {
  j.scale_covariance = scale_of_covariance(j.nees);
  const double alpha = 1.0 - j.confidence;
  const auto shared = [alpha](const SensorPairJudgement& p) { return p.correlation.p_value <= alpha; };
  j.scale_innovation = std::ranges::any_of(j.law.sensor_pairs, shared)
                           ? no_scale("sensors of the same step are correlated")
                           : context.scale_innovation.value_or(scale_of_sensors(j));
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
  j.credibility = n > 0 && enough ? credibility_index(runs.last_error, runs.last_covariance, j.confidence)
                                  : CredibilityIndex{.reason = "fewer whole runs than dimensions"};
  j.error_correlation = test_error_correlation(runs.last_whitened);
  if (runs.last_whitened.count == 0)
    j.error_correlation.reason = "no run ends with a P of full rank over its states, of at most 60";
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

/// NEES without the rows of gross outliers, judged as with them where its course is known, of one dof.
ConsistencyVerdict judge_without_outliers(const Evidence& e, double memory, double confidence) {
  const StepSeries nees = series_of(e.clean_nees, e.study.steps.size());
  const double dof = constant_dof(e.study);
  const std::vector<std::vector<double>>& all = e.whole_runs.nees;
  if (std::isnan(dof) || std::ssize(all) != e.study.nees_of_runs.moments.count)
    return judge_state(e, nees, confidence);
  const double most = outlier_limit(static_cast<Index>(dof)) / dof;
  std::vector<std::vector<double>> runs;
  RunAverages averages;
  for (const std::vector<double>& run : all) {
    std::vector<double> kept;
    std::ranges::copy_if(run, std::back_inserter(kept), [most](double x) { return x <= most; });
    const auto rows = static_cast<double>(kept.size());
    averages.add(dof * std::accumulate(kept.begin(), kept.end(), 0.0), dof * rows,
                 e.study.nees_of_runs.least_dof);
    if (!kept.empty()) runs.push_back(std::move(kept));
  }
  const auto judge = [&](const RunAverages& of_runs) { return judge_state(e, nees, confidence, &of_runs); };
  if (runs.size() != 1) return judge_runs(averages, stretches_of(e, runs, memory).averages, judge);
  Judgement single;
  single.confidence = confidence;
  single.nees = judge(averages);
  judge_single_run(e, runs.front(), memory, single);
  return single.nees;
}

/// Of several sensors the sum alone, by a bound that is blind to what single ones reject.
ConsistencyVerdict judge_nis_without_outliers(const Evidence& e, double confidence) {
  const StepSeries nis = series_of(e.clean_nis, e.study.steps.size());
  ConsistencyVerdict v = judge_all_sensors(e, nis, confidence);
  if (e.sensors.size() > 1 && v.verdict == Verdict::consistent) {
    v.verdict = Verdict::undecided;
    v.reason = "without outliers the sum over the sensors alone is known";
  }
  return v;
}

void judge_sensitivity(const Evidence& e, double memory, Judgement& j) {
  j.sensitivity = SensitivityJudgement{
      .nees_outliers = e.nees_outliers,
      .nis_outliers = e.nis_outliers,
      .nees = e.nees_outliers == 0 ? j.nees : judge_without_outliers(e, memory, j.confidence),
      .nis = e.nis_outliers == 0 ? j.nis : judge_nis_without_outliers(e, j.confidence)};
}

/// Which steps of the runs the steps judged are.
void name_steps(const Evidence& e, const JudgementContext& context, Judgement& j) {
  j.step_stride = e.step_stride;
  // Of all runs every step is there.
  const std::int64_t stride_of_all = context.all_runs != nullptr ? 1 : e.step_stride;
  const auto name = [&](ConsistencyVerdict& v, std::int64_t stride) {
    v.step_stride = stride;
    v.times = context.times;
  };
  for (BlockVerdict& block : j.blocks) name(block.verdict, e.step_stride);
  for (SensorJudgement& sensor : j.sensors) name(sensor.nis, e.step_stride);
  name(j.nees, stride_of_all);
  name(j.nis, stride_of_all);
  if (j.vehicle_nees) name(*j.vehicle_nees, stride_of_all);
}

/// Of the runs that ended well and of those that failed, by their numbers.
std::vector<CourseOfRun> courses_of(const Evidence& e) {
  std::vector<CourseOfRun> all = e.whole_runs.failed;
  std::set<std::int64_t> failed;
  for (const RunFailure& failure : e.study.failures) failed.insert(failure.run);
  std::int64_t run = 0;
  for (const RunCourse& course : e.whole_runs.courses(static_cast<double>(e.study.nees_of_runs.least_dof))) {
    while (failed.contains(run)) ++run;
    all.push_back({.run = run++, .course = course});
  }
  std::ranges::sort(all, {}, &CourseOfRun::run);
  return all;
}

LostRuns lost_runs_of(const Evidence& e, const ConsistencyVerdict& nees, std::span<const std::string> names) {
  if (!e.has_truth || !e.joint_covariance || e.whole_runs.nees.empty()) return {};
  LostRuns lost = find_lost_runs(courses_of(e));
  if (std::ssize(names) == e.study.runs) {
    for (LostRun& run : lost.runs) run.name = names[static_cast<std::size_t>(run.run)];
  }
  lost.last = e.study.runs - 1;
  lost.by_step = rows_are_steps(e.whole_runs, nees);
  return lost;
}

/// Errors of single rows, where nothing is wrong without them, are the cause of all that is wrong with P.
void name_outliers(const Evidence& e, const JudgementContext& context, double memory, Judgement& j) {
  const double dof = constant_dof(e.study);
  if (j.word.verdict != Verdict::optimistic || !j.lost.runs.empty() || e.nees_outliers == 0) return;
  if (std::isnan(dof) || std::ssize(e.whole_runs.nees) != e.study.nees_of_runs.moments.count) return;
  const std::optional<LoneOutliers> outliers = find_lone_outliers(e.whole_runs.nees, dof);
  if (!outliers) return;
  const ConsistencyVerdict rest = judge_without_outliers(e, memory, j.confidence);
  if (is_inconsistent(rest.verdict)) return;
  const bool named = std::ssize(context.run_names) == e.study.runs && e.study.failures.empty();
  const std::string run = named ? context.run_names[static_cast<std::size_t>(outliers->run)]
                                : fmt::format("run {}", outliers->run);
  const bool measured = e.nis_outliers > 0;
  // What a Jacobian at a wrong estimate makes of P the next measurement may mend.
  const bool of_step = !measured && e.layout.nonlinear && outliers->at_one_step;
  const CauseFound cause = {
      measured  ? Cause::outliers
      : of_step ? Cause::one_step
                : Cause::truth,
      fmt::format(
          "{} of {} rows have errors beyond any that P leaves room for, one at a time{} (first: {}, its "
          "row {}); without them mean NEES is {} of {}",
          outliers->count, outliers->rows,
          measured
              ? fmt::format(", and {} innovation{} likewise", e.nis_outliers, e.nis_outliers == 1 ? "" : "s")
          : of_step ? ", and all at one step: a measurement far from linear, or a glitch of the truth"
                    : ", where those of a filter fade: a glitch of the truth, or of what was logged",
          run, outliers->row + 1, number_text(rest.mean, 4), number_text(rest.expected, 4))};
  const auto of_innovations = [](const JoinedVerdict& part) {
    return is_inconsistent(part.verdict) && part.name.starts_with("NIS");
  };
  if (std::ranges::none_of(j.word.joined, of_innovations)) j.causes.clear();
  std::erase_if(j.causes, [&cause](const CauseFound& other) { return other.cause == cause.cause; });
  j.causes.insert(j.causes.begin(), cause);
  refuse_factor("errors of single rows alone are wrong", j);
}

/// More than a size of the innovations makes them look that goes up and down in time: it doubles the variance
/// of their products at most where it is 0 or twice what S says. NIS of coloured ones, as of a gain that is
/// not the best one, have a memory of their own.
bool clearly_coloured(const WhitenessTest& test, double confidence) {
  constexpr double kMost = 2.0;
  return test.reason.empty() && chi_square_survival(test.statistic / kMost, test.dof) <= 1.0 - confidence;
}

/// The verdicts, tests and factors of all that there is.
void judge_evidence(const Evidence& e, const JudgementContext& context, double memory, Judgement& j) {
  const StudyStatistics& all = context.all_runs != nullptr ? *context.all_runs : e.study;
  FewRuns few{.memory = memory, .state = stretches_of(e, all, memory)};
  few.blocks = block_stretches_of(e, few.state);
  j.nees_over_time = nees_over_time(e);
  if (!j.nees_over_time.empty()) {
    const auto least = std::ranges::min_element(j.nees_over_time, {}, &NeesOverTime::p_value);
    few.nees_over_time = std::min(1.0, static_cast<double>(j.nees_over_time.size()) * least->p_value);
  }
  for (std::size_t i = 0; i < e.sensors.size(); ++i) {
    const Modulation over_time = nis_over_time(e.sensors[i]);
    few.nis_over_time.push_back(over_time.p_value);
    if (!clearly_coloured(j.sensors[i].whiteness, j.confidence)) j.sensors[i].over_time = over_time;
  }
  const SkewedMoments averages = averages_compared(e, few.state);
  judge_verdicts(e, all, averages, j);
  judge_blocks(e, context, few, j);
  name_steps(e, context, j);
  for (std::size_t i = 0; i < j.coverage.size(); ++i) {
    j.coverage[i] = judge_region(e.coverage.regions[i], j.confidence);
  }
  judge_ends(e, j);
  const ClaimedSigmaTest& claimed = context.claimed_sigma;
  j.law = judge_law(e, all, j.confidence, context.margin,
                    std::fmin(claimed.optimistic.p_value, claimed.pessimistic.p_value), few);
  j.effective_steps = effective_steps_of(e.whole_runs, e.study.steps.size());
  judge_scales(e, context, j);
  j.settle_nees = std::isnan(j.effective_steps) ? settle_few(e, all, averages, j)
                                                : settle(j.nees, false, j.effective_steps);
  const SquareCorrelation correlation = longest_correlation(j);
  j.settle_nis =
      settle(j.nis, correlation.known && correlation.of_sum == 1.0,
             correlation.known ? static_cast<double>(j.nis.steps_tested) / correlation.of_sum : kNaN);
  if (e.study.runs == 1 && (context.all_runs == nullptr || context.all_runs->runs == 1))
    judge_single_run(e, e.first_run, memory, j);
}

/// One word over the verdicts, and which runs and states it is of.
void say_word(const Evidence& e, const JudgementContext& context, Judgement& j) {
  open_zero_rows(j);
  j.lost = lost_runs_of(e, j.nees, context.run_names);
  j.word = word_of(e, j);
  if (j.single && std::isnan(j.single->time_average.p_value) && j.word.verdict == Verdict::consistent) {
    leave_open(e, j);  // a step that alone rejects is no reason to call it consistent
    j.word = word_of(e, j);
  }
  const bool fitted = context.truth_fit != TruthFit::none;
  if (fitted) judge_fitted(context.truth_fit, j);
  leave_heavy_open(e, j);
  follow_word(j.word, j.blocks, j.responsible);
  if (!is_inconsistent(j.word.verdict) || fitted) {
    j.responsible = {};
    j.lost = {};
  }
  if (j.lost.runs.empty()) return;
  j.scale_covariance = j.scale_innovation = no_scale("a few runs alone are wrong");
  j.responsible.joint_only = false;
}

void name_causes(const Evidence& e, const JudgementContext& context, double memory, Judgement& j) {
  if (context.truth_fit == TruthFit::none) {
    j.causes = find_causes(findings_of(e, j));
    const auto first_is = [&j](Cause cause) { return !j.causes.empty() && j.causes.front().cause == cause; };
    const bool unwrapped = first_is(Cause::unwrapped_angle);
    if (unwrapped || first_is(Cause::one_step)) {
      refuse_factor(
          unwrapped ? "an angle is not wrapped" : "what happens at one step is most of what is wrong", j);
      j.scale_innovation = j.scale_covariance;
    }
    if (!unwrapped) name_outliers(e, context, memory, j);
  }
  if (!context.copies.empty() && (is_inconsistent(j.word.verdict) || !j.causes.empty()))
    j.causes = {{Cause::shared_noise, context.copies}};
}

}  // namespace

Judgement judge(const Evidence& e, const JudgementContext& context) {
  Judgement j;
  j.runs = e.study.runs;
  j.confidence = context.confidence;
  j.claimed_sigma = context.claimed_sigma;
  for (const SensorSums& sensor : e.sensors) {
    j.sensors.push_back(judge_sensor(sensor, e.study.steps.size(), j.confidence, context.gate));
    if (sensor.sensor.variances_alone)
      j.sensors.back().pairs = {.reason = "S is known by its variances alone"};
  }
  const double memory = context.memory ? *context.memory : memory_in_rows(e);
  judge_evidence(e, context, memory, j);
  say_word(e, context, j);
  j.tests = list_tests(e, j);
  if (!e.has_truth) leave_coloured_open(j);
  leave_rejected_open(e, j);
  leave_certain_open(e, j);
  leave_zeros_open(j);
  leave_one_size_open(e, j);
  leave_failed_open(context.all_runs != nullptr ? *context.all_runs : e.study, j);
  name_causes(e, context, memory, j);
  if (context.sensitivity) judge_sensitivity(e, memory, j);
  return j;
}

std::string_view to_string(Exactness exactness) {
  return word_of(exactness, {"exact", "approximate", "conservative"});
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
