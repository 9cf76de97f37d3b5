#include "analysis/evidence/verdicts/judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "analysis/evidence/causes/cause_findings.h"
#include "analysis/evidence/causes/lone_outliers.h"
#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/evidence/verdicts/judgement_settling.h"
#include "analysis/evidence/verdicts/judgement_tests.h"
#include "analysis/evidence/verdicts/series_verdicts.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/mean/correlated_mean.h"
#include "core/nan.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

constexpr std::string_view kLasting = "the innovations are correlated over more steps than are looked at";

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

/// Of innovations that are not white, also about their mean.
SquareCorrelation correlation_in_time(const SensorSums& s, const WhitenessTest& whiteness,
                                      double confidence) {
  const auto is_coloured = [](const WhitenessTest& test) { return test.reason.empty() && !test.white; };
  if (!is_coloured(whiteness)) return {};
  const LagProducts products =
      s.varies ? s.scalar_lags.about(s.scalar_values.mean) : s.lags.about(s.values.mean);
  if (!is_coloured(test_whiteness(products, confidence))) return {};
  return s.sensor.nis_alone ? score_correlation(products) : square_correlation(products);
}

/// Of NIS that may be correlated over any time: as NEES is judged, by equal stretches of its mean over the
/// runs that are long enough, or else by the bound for every dependence.
ConsistencyVerdict judge_lasting_nis(const SensorSums& s, const StepSeries& nis, double confidence) {
  const std::vector<double> means = normalised_nis(s);
  const RunAverages stretches{.moments = stretch_averages(std::span(&means, 1)).averages};
  ConsistencyVerdict v = judge_nees(nis.moments, nis.dof, confidence, &stretches);
  if (stretches.moments.count > 0) {
    v.method = fmt::format(
        "every step (Bonferroni) and the averages of {} stretches, longer than ten correlation times each",
        stretches.moments.count);
  }
  return v;
}

/// The verdict on the NIS of one sensor.
ConsistencyVerdict judge_sensor_nis(const SensorSums& s, const std::optional<GateFound>& gate,
                                    const SquareCorrelation& correlation, const StepSeries& nis,
                                    double confidence) {
  if (!gate && !correlation.known) return judge_lasting_nis(s, nis, confidence);
  if (!gate) return judge_nis(nis.moments, nis.dof, confidence, correlation.of_sum);
  const double steps = static_cast<double>(s.nis.size());  // as if all were one value
  return judge_gated_nis(nis.moments, static_cast<double>(s.by_dimension.begin()->first), gate->nis,
                         confidence, correlation.known ? correlation.of_sum : steps);
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

/// NIS within a gate beyond which the first bins have none, against the law cut off there.
GoodnessOfFit fit_within(const SensorSums& s, std::size_t bins) {
  return test_uniform(UniformHistogram(std::span(s.fit.counts()).first(bins), s.fit.invalid()));
}

/// A gate, certain or not, where that many empty bins at the top are hardly chance, the rest is not clearly
/// of another law, and none of a factor on S is likelier: of a filter whose gate is not seen NIS are too
/// small.
std::optional<GateFound> find_gate(const SensorSums& s, double confidence) {
  constexpr double kFewest = 3.0;  // values expected beyond; none there has probability 0.05
  constexpr double kMisfit = 0.1;  // of the level
  if (s.by_dimension.size() != 1) return std::nullopt;
  const std::vector<std::int64_t>& counts = s.fit.counts();
  std::size_t used = counts.size();
  while (used > 0 && counts[used - 1] == 0) --used;
  const auto values = static_cast<double>(s.fit.count());
  const double expected =
      values * static_cast<double>(counts.size() - used) / static_cast<double>(counts.size());
  if (used < 2 || expected < kFewest) return std::nullopt;
  const GoodnessOfFit fit = fit_within(s, used);
  if (!(fit.anderson_p_value > kMisfit * (1.0 - confidence))) return std::nullopt;
  const auto dof = static_cast<double>(s.by_dimension.begin()->first);
  const double scale = s.by_dimension.begin()->second.value.mean / dof;
  const double scaled = 0.5 * dof * (scale - 1.0 - std::log(scale));  // of each value, over that of χ²
  const double cut_off = -std::log(chi_square_cdf(s.largest_nis, dof));
  const double over_scaled = values * (cut_off - scaled);
  if (!(over_scaled >= 0.0)) return std::nullopt;
  return GateFound{s.largest_nis, expected, fit.anderson_p_value, over_scaled};
}

/// Values with so few digits that their steps would be taken for another law: with n values on a grid of G
/// places, some n/G of them are equal to another, and steps of 1/G show to the test from about 0.1/√n on.
bool is_rounded(const CoverageCount& ties) {
  constexpr double kShare = 0.1;
  constexpr std::int64_t kFewest = 20;
  return ties.total >= kFewest && static_cast<double>(ties.inside) > kShare * static_cast<double>(ties.total);
}

/// Of values of one dimension that a known gate has let through: their law, and the gate.
void judge_within_gate(const SensorSums& s, double gate, SensorJudgement& result) {
  if (!std::isfinite(gate) || s.by_dimension.size() != 1) return;
  const double within = chi_square_cdf(gate, static_cast<double>(s.by_dimension.begin()->first));
  const auto bins = static_cast<double>(s.fit.counts().size());
  const double used = std::clamp(std::ceil(within * bins), 2.0, bins);
  result.fit = fit_within(s, static_cast<std::size_t>(used));
  result.gate = GateFound{.nis = gate,
                          .expected = static_cast<double>(s.fit.count()) * (1.0 - within) / within,
                          .p_value = result.fit.anderson_p_value,
                          .known = true};
}

SensorJudgement judge_sensor(const SensorSums& s, std::size_t steps, double confidence, double gate) {
  SensorJudgement result;
  result.name = s.sensor.name;
  result.of_sum = s.varies;
  const StepSeries nis = series_of(s.nis, steps);
  result.fit = test_uniform(s.fit);
  judge_within_gate(s, gate, result);
  if (!result.gate) {
    if (const std::optional<GateFound> found = find_gate(s, confidence))
      (found->is_certain() ? result.gate : result.perhaps_gate) = found;
  }
  const LagProducts& lags = s.varies ? s.scalar_lags : s.lags;
  result.whiteness = test_whiteness(lags, confidence);
  result.correlation = correlation_in_time(s, result.whiteness, confidence);
  result.nis = judge_sensor_nis(s, result.gate, result.correlation, nis, confidence);
  const VectorMoments& means = s.varies ? s.scalar_run_means : s.run_means;
  const bool enough_runs = means.count > 0 && means.count > means.mean.size() + 1;
  if (s.sensor.nis_alone) {
    result.mean = {.p_value = kNaN, .reason = "NIS alone has no sign"};
  } else if (enough_runs) {
    result.mean = test_zero_mean(means);
  } else {
    result.mean = test_correlated_mean(s.varies ? s.scalar_values : s.values, lags, confidence);
  }
  const auto test = [&](const std::vector<Moments>& values) {
    if (result.gate) return ComponentTest{.reason = "innovations had to pass a gate"};
    if (!result.correlation.known) return ComponentTest{.reason = kLasting};
    return test_components(s.varies ? std::span<const Moments>() : values, confidence,
                           result.correlation.of_component);
  };
  result.components = test(s.components);
  result.pairs = test(s.pairs);
  if (is_rounded(s.ties)) {
    result.fit.kolmogorov_p_value = result.fit.anderson_p_value = kNaN;
    result.fit.reason = "not tested: the values are rounded, as many are equal to another";
  }
  result.histogram = s.fit.counts();
  return result;
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

void judge_sensitivity(const Evidence& e, double memory, Judgement& j) {
  const StepSeries nis = series_of(e.clean_nis, e.study.steps.size());
  j.sensitivity = SensitivityJudgement{.nees_outliers = e.nees_outliers,
                                       .nis_outliers = e.nis_outliers,
                                       .nees = judge_without_outliers(e, memory, j.confidence),
                                       .nis = judge_all_sensors(e, nis, j.confidence)};
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

/// By their numbers among all runs, of which the evidence has those that ended well.
LostRuns lost_runs_of(const Evidence& e, std::span<const std::string> names) {
  if (!e.has_truth || !e.joint_covariance || e.whole_runs.nees.empty()) return {};
  LostRuns lost = find_lost_runs(e.whole_runs.courses(static_cast<double>(e.study.nees_of_runs.least_dof)));
  for (LostRun& run : lost.runs) {
    for (const RunFailure& failure : e.study.failures) run.run += failure.run <= run.run ? 1 : 0;
    const bool named = std::ssize(names) == e.study.runs;
    if (named) run.name = names[static_cast<std::size_t>(run.run)];
  }
  return lost;
}

/// A test of averages over the steps, as a part of the word.
ConsistencyVerdict averaged_verdict(const DirectedPValues& p_value, std::int64_t steps, std::int64_t count) {
  ConsistencyVerdict verdict;
  verdict.verdict = Verdict::consistent;
  verdict.optimistic_p_value = p_value.optimistic;
  verdict.pessimistic_p_value = p_value.pessimistic;
  verdict.steps_tested = steps;
  verdict.count = count;
  return verdict;
}

/// What is too large at several steps, all of them in the first tenth, where heavy tails alone hardly gather;
/// null: nothing is.
const ConsistencyVerdict* wrong_at_start(const Judgement& j) {
  constexpr std::int64_t kFewest = 3, kTenths = 10;
  const auto is_wrong = [](const ConsistencyVerdict& v) {
    return v.optimistic_steps.count >= kFewest && kTenths * v.optimistic_steps.last <= std::ssize(v.steps);
  };
  if (is_wrong(j.nees)) return &j.nees;
  for (const BlockVerdict& block : j.blocks) {
    if (is_wrong(block.verdict)) return &block.verdict;
  }
  return nullptr;
}

/// NEES, NIS of each sensor, its components and pairs of them, which share what NIS has, NEES and NIS over
/// time, the blocks, the directions of P, and P by the σ that it claims.
Word word_of(const Evidence& e, const Judgement& j) {
  std::vector<WordPart> parts = word_parts(j.nees, j.nis, j.blocks);
  if (j.sensors.size() > 1) {
    const double each = parts[1].weight / static_cast<double>(j.sensors.size());
    parts.erase(parts.begin() + 1);
    for (const SensorJudgement& s : j.sensors)
      parts.push_back({"NIS of " + s.name, &s.nis, each, false, true});
  }
  std::deque<ConsistencyVerdict> averages;  // whose places stay
  for (std::size_t i = 0; i < j.sensors.size(); ++i) {
    const SensorJudgement& sensor = j.sensors[i];
    if (!sensor.components.reason.empty()) continue;
    const auto nis =
        std::ranges::find(parts, j.sensors.size() == 1 ? &j.nis : &sensor.nis, &WordPart::verdict);
    nis->weight *= 0.5;
    const double half = (sensor.pairs.components.empty() ? 1.0 : 0.5) * nis->weight;
    const auto add = [&](const ComponentTest& test, std::string (*name)(const SensorJudgement&, Index)) {
      const double each = half / static_cast<double>(test.components.size());
      for (Index k = 0; const ComponentVariance& c : test.components) {
        averages.push_back(averaged_verdict(c.p_value, c.count, c.count));
        parts.push_back({name(sensor, k++), &averages.back(), each, false, true, true});
      }
    };
    add(sensor.components, component_name);
    add(sensor.pairs, pair_name);
  }
  // Whether it is larger at some time than it should be, and smaller, is told by the size of its waves.
  const auto add_over_time = [&](const std::string& of, const Modulation& over_time,
                                 const ConsistencyVerdict& v, double weight, bool of_S) {
    const double p = over_time.p_value, mean = v.mean / v.expected;
    if (std::isnan(p)) return;
    const auto add = [&](const char* when, const DirectedPValues& p_value) {
      averages.push_back(averaged_verdict(p_value, 1, v.count));
      parts.push_back({of + when, &averages.back(), 0.5 * weight, false, of_S, true});
    };
    add(kAtSomeTimes, {mean * (1.0 + over_time.amplitude) > 1.0 ? p : 1.0, kNaN});
    add(kAtOthers, {kNaN, mean * (1.0 - over_time.amplitude) < 1.0 ? p : 1.0});
  };
  for (const NeesOverTime& nees : j.nees_over_time) {
    const auto block = std::ranges::find(j.blocks, nees.of, &BlockVerdict::name);
    const ConsistencyVerdict& v = block == j.blocks.end() ? j.nees : block->verdict;
    const double parts_of_it = static_cast<double>(j.nees_over_time.size() - 1);
    const double share = parts_of_it == 0.0 ? 1.0 : nees.of.empty() ? 0.5 : 0.5 / parts_of_it;
    add_over_time(nees.part(), nees, v, share * kWordOverTime, false);
  }
  for (const SensorJudgement& sensor : j.sensors) {
    add_over_time(of_sensor("NIS", sensor), sensor.over_time, sensor.nis,
                  kWordOverTime / static_cast<double>(j.sensors.size()), true);
  }
  const SecondMomentJudgement& second = j.law.second_moments;
  if (second.test.reason.empty()) {
    averages.push_back(averaged_verdict(second.test.p_value, std::ssize(e.study.steps), second.test.runs));
    parts.push_back({.name = "the direction of " + second.most_optimistic,
                     .verdict = &averages.back(),
                     .weight = kWordDirections,
                     .says_where = true,
                     .pessimistic_name = "the direction of " + second.most_pessimistic});
  }
  const auto add_claimed = [&](const ClaimedSigmaTest::Side& side, const DirectedPValues& p_value) {
    if (std::isnan(side.p_value)) return;
    averages.push_back(averaged_verdict(p_value, 1, j.claimed_sigma.units));
    parts.push_back({side.in, &averages.back(), 0.5 * kWordClaimedSigma, true});
  };
  add_claimed(j.claimed_sigma.optimistic, {j.claimed_sigma.optimistic.p_value, kNaN});
  add_claimed(j.claimed_sigma.pessimistic, {kNaN, j.claimed_sigma.pessimistic.p_value});
  Word word = join_verdicts(parts, j.confidence);
  if (is_inconsistent(word.verdict) && !j.lost.runs.empty()) {
    word.of_few = true;
    const bool alone = j.lost.others_are_right();
    word.says = fmt::format("{}{} {}{}", to_string(word.verdict), alone ? " in" : ", above all in",
                            names_of(j.lost), alone ? " alone" : "");
    if (j.lost.runs.size() == 1) word.says += fmt::format(", from its row {} on", j.lost.runs.front().row);
  } else if (is_inconsistent(word.verdict) && j.law.gaussianity.right_but_heavy_tailed(1.0 - j.confidence)) {
    word.verdict = Verdict::not_gaussian;
    const ConsistencyVerdict* const start = wrong_at_start(j);
    word.says = start == nullptr
                    ? "the covariance is right, the errors are not Gaussian (heavy tails)"
                    : fmt::format(
                          "the covariance is right but perhaps in {}, where it is too small or the tails "
                          "are heavier; the errors are not Gaussian (heavy tails)",
                          start->text_of(start->optimistic_steps));
  }
  return word;
}

/// A block that the answer names is the one of which more is said.
void follow_word(const Word& word, std::span<const BlockVerdict> blocks, ResponsibleBlock& responsible) {
  for (const std::string& name : word.named) {
    const auto block = std::ranges::find(blocks, name, &BlockVerdict::name);
    if (block == blocks.end()) continue;
    responsible = {.index = block - blocks.begin()};
    return;
  }
}

/// Of a truth that was fitted to these errors, where the sum of NEES is least, only one thing is known: that
/// their mean NEES is no larger than where it belongs. Of one that could not be fitted nothing is.
void judge_fitted(TruthFit fit, Judgement& j) {
  const double alpha = 1.0 - j.confidence;
  double p = j.nees.overall_p_value;
  if (j.single && !std::isnan(j.single->time_average.p_value)) {
    const double stretches = j.single->time_average.p_value;
    p = std::isnan(p) ? stretches : std::min(1.0, 2.0 * std::min(p, stretches));
  }
  const bool optimistic = fit == TruthFit::least_nees && j.nees.mean > j.nees.expected && p <= alpha;
  const std::string open =
      fit == TruthFit::least_nees
          ? "the truth was fitted to these errors, which may be what makes them deviate"
          : "where the truth belongs is not known, which may be what makes errors deviate";
  const auto leave = [&](ConsistencyVerdict& v) {
    if (!is_inconsistent(v.verdict)) return;
    v.verdict = Verdict::undecided;
    v.reason = open;
  };
  for (BlockVerdict& block : j.blocks) leave(block.verdict);
  if (j.vehicle_nees) leave(*j.vehicle_nees);
  if (optimistic) {
    j.nees.verdict = j.word.verdict = Verdict::optimistic;
    j.nees.decided_by_steps = false;
    j.word.says = "optimistic in the mean NEES, wherever the truth lies";
  } else {
    leave(j.nees);
    if (j.word.verdict != Verdict::consistent) j.word.verdict = Verdict::undecided;
    j.word.says.clear();
    if (j.word.verdict == Verdict::undecided && j.nees.reason.empty()) j.nees.reason = open;
  }
  j.word.p_value = j.nees.mean > j.nees.expected ? p : 1.0;
  j.word.joined.clear();
}

/// Of failed runs and rejected rows, beyond which the others do not speak for the filter.
constexpr double kMostLost = 0.05;

void leave_word_open(std::string reason, Judgement& j) {
  j.word.verdict = Verdict::undecided;
  j.word.says.clear();
  j.nees.reason = std::move(reason);
}

/// Steps whose NEES is too large are no evidence against P where tails are heavy, if nothing else accuses it
/// and nothing that needs no law could have.
void leave_heavy_open(Judgement& j) {
  const GaussianityJudgement& g = j.law.gaussianity;
  const double alpha = 1.0 - j.confidence;
  if (!is_inconsistent(j.word.verdict) || j.word.of_few) return;
  if (!g.heavy_tailed(alpha) || !std::isnan(g.moments_p_value)) return;
  const bool on_average = j.single && j.single->time_average.p_value <= alpha;
  const ConsistencyVerdict* of_steps = nullptr;
  for (const JoinedVerdict& part : j.word.joined) {
    if (!is_inconsistent(part.verdict)) continue;
    const auto block = std::ranges::find(j.blocks, part.name, &BlockVerdict::name);
    if (block == j.blocks.end() && part.name != "NEES") return;
    const ConsistencyVerdict& v = block == j.blocks.end() ? j.nees : block->verdict;
    if (part.verdict != Verdict::optimistic || v.overall_p_value <= alpha || on_average) return;
    of_steps = &v;
  }
  if (of_steps == nullptr) return;
  leave_word_open(
      fmt::format("single rows are too large ({}), but the errors have heavy tails, with which some are, and "
                  "the runs are too short for tests that need no law",
                  when_text(*of_steps, Verdict::optimistic)),
      j);
}

/// A run that failed has no rows where the filter was worst. Where many have, the others do not speak for it.
void leave_failed_open(const StudyStatistics& all, Judgement& j) {
  if (is_unsafe(j.word.verdict)) return;
  const auto failed = std::ssize(all.failures);
  if (static_cast<double>(failed) <= kMostLost * static_cast<double>(all.runs)) return;
  leave_word_open(fmt::format("{} of {} runs failed{}", failed, all.runs,
                              failed < all.runs ? ", and the others do not speak for them" : ""),
                  j);
}

/// A rejected row has a P, or an error, that is none. Where many are, the others do not speak for the filter.
void leave_rejected_open(const Evidence& e, Judgement& j) {
  if (is_unsafe(j.word.verdict)) return;
  std::int64_t judged = e.has_truth ? j.nees.count : j.nis.count;
  for (const BlockVerdict& block : j.blocks) judged = std::max(judged, block.verdict.count);
  const std::int64_t rejected = e.rejected_rows(), all = rejected + judged;
  if (static_cast<double>(rejected) <= kMostLost * static_cast<double>(all)) return;
  const auto count = [](const auto& of_reason) { return of_reason.second.count; };
  leave_word_open(
      fmt::format("{} of {} rows are rejected (most of them: {}), and the others do not speak for them",
                  rejected, all, std::ranges::max_element(e.rejected, {}, count)->first),
      j);
}

/// Without a truth a mean NIS that is right says that S is. Innovations that are not white are those of a
/// gain that is not the best one, and then the P behind it may be anything.
void leave_coloured_open(Judgement& j) {
  if (j.word.verdict != Verdict::consistent && j.word.verdict != Verdict::not_gaussian) return;
  const auto coloured = std::ranges::find_if(
      j.sensors, [&](const SensorJudgement& s) { return speaks(j, of_sensor(kWhiteness, s)); });
  if (coloured == j.sensors.end()) return;
  leave_word_open(
      fmt::format(
          "the mean NIS is right, but the innovations{} are not white ({}): the gain is not the best one, "
          "so that P need not be right",
          coloured->name.empty() ? "" : " of " + coloured->name,
          p_value_statement(coloured->whiteness.p_value)),
      j);
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
  const CauseFound cause = {
      measured ? Cause::outliers : Cause::truth,
      fmt::format(
          "{} of {} rows have errors beyond any that P leaves room for, one at a time{} (first: {}, its "
          "row {}); without them mean NEES is {} of {}",
          outliers->count, outliers->rows,
          measured
              ? fmt::format(", and {} innovation{} likewise", e.nis_outliers, e.nis_outliers == 1 ? "" : "s")
              : ", where those of a filter fade: a glitch of the truth, or of what was logged",
          run, outliers->row + 1, number_text(rest.mean, 4), number_text(rest.expected, 4))};
  const auto of_innovations = [](const JoinedVerdict& part) {
    return is_inconsistent(part.verdict) && part.name.starts_with("NIS");
  };
  if (std::ranges::none_of(j.word.joined, of_innovations)) j.causes.clear();
  j.causes.insert(j.causes.begin(), cause);
  j.scale_covariance = no_scale("errors of single rows alone are wrong");
  j.word.of_few = true;
}

/// More than a size of the innovations makes them look that goes up and down in time: it doubles the variance
/// of their products at most where it is 0 or twice what S says. NIS of coloured ones, as of a gain that is
/// not the best one, have a memory of their own.
bool clearly_coloured(const WhitenessTest& test, double confidence) {
  constexpr double kMost = 2.0;
  return test.reason.empty() && chi_square_survival(test.statistic / kMost, test.dof) <= 1.0 - confidence;
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
  const StudyStatistics& all = context.all_runs != nullptr ? *context.all_runs : e.study;
  const double memory = context.memory ? *context.memory : memory_in_rows(e);
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
  j.lost = lost_runs_of(e, context.run_names);
  j.word = word_of(e, j);
  if (j.single && std::isnan(j.single->time_average.p_value) && j.word.verdict == Verdict::consistent) {
    leave_open(e, j);  // a step that alone rejects is no reason to call it consistent
    j.word = word_of(e, j);
  }
  const bool fitted = context.truth_fit != TruthFit::none;
  if (fitted) judge_fitted(context.truth_fit, j);
  leave_heavy_open(j);
  follow_word(j.word, j.blocks, j.responsible);
  if (!is_inconsistent(j.word.verdict) || fitted) {
    j.responsible = {};
    j.lost = {};
  }
  if (!j.lost.runs.empty()) {
    j.scale_covariance = j.scale_innovation = no_scale("a few runs alone are wrong");
    j.responsible.joint_only = false;
  }
  j.tests = list_tests(e, j);
  if (!e.has_truth) leave_coloured_open(j);
  leave_rejected_open(e, j);
  leave_failed_open(all, j);
  if (!fitted) {
    j.causes = find_causes(findings_of(e, j));
    name_outliers(e, context, memory, j);
  }
  if (!context.copies.empty() && (is_inconsistent(j.word.verdict) || !j.causes.empty()))
    j.causes = {{Cause::shared_noise, context.copies}};
  if (context.sensitivity) judge_sensitivity(e, memory, j);
  return j;
}

std::string_view to_string(Exactness exactness) {
  switch (exactness) {
    case Exactness::exact: return "exact";
    case Exactness::approximate: return "approximate";
    case Exactness::conservative: return "conservative";
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
