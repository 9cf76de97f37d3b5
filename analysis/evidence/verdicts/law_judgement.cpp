#include "analysis/evidence/verdicts/law_judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "analysis/evidence/sums/step_normaliser.h"
#include "analysis/evidence/verdicts/series_verdicts.h"
#include "analysis/laws/correlation/error_residuals.h"
#include "analysis/laws/correlation/modulation.h"
#include "analysis/laws/mean/equivalence.h"
#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/mean/step_profile.h"
#include "analysis/laws/mean/student.h"
#include "analysis/laws/shape/tail_weight.h"

namespace credence::internal {
namespace {

/// With fewer runs a mean over them says little without a law.
constexpr std::int64_t kFewestRuns = 20;

/// With fewer values a mean over them says little without a law.
constexpr std::int64_t kFewestValues = 100;

/// So far in the tails, the skewness of a few heavy-tailed values is not all removed.
constexpr double kMoreForSkewed = 10.0;

/// Takes p-values one by one, those that are not made left out, for Bonferroni's bound.
class SmallestPValue {
 public:
  void add(double p) {
    if (std::isnan(p)) return;
    smallest_ = std::min(smallest_, p);
    ++tests_;
  }
  double adjusted() const {
    return tests_ == 0 ? kNaN : std::min(1.0, smallest_ * static_cast<double>(tests_));
  }

 private:
  double smallest_ = 1.0;
  std::int64_t tests_ = 0;
};

double two_sided(const SkewedMoments& values) {
  return values.count < kFewestRuns ? kNaN : run_mean_p_values(values, 1.0).two_sided();
}

ShapeJudgement judge_shape(const LawSums& law, double confidence) {
  ShapeJudgement result{.reason = "not more runs than states, or too many states"};
  double smallest = 2.0;
  for (const auto& [step, whitened] : law.whitened) {
    const CovarianceShape shape = test_covariance_shape(whitened, confidence);
    if (!shape.reason.empty()) continue;
    ++result.tests;
    result.proved_within = shape.proved_within;
    result.proved_at = step;
    if (shape.p_value >= smallest) continue;
    smallest = shape.p_value;
    result.step = step;
    result.shape = shape;
  }
  if (result.tests == 0) return result;
  result.reason = {};
  result.p_value = std::min(1.0, smallest * static_cast<double>(result.tests));
  return result;
}

/// The states that the second moments are of.
std::vector<std::string> averaged_states(const Evidence& e) {
  const bool whole = std::ssize(e.layout.states) == e.law.second_moments.dim();
  if (e.law.averaged.empty()) return whole ? e.layout.states : std::vector<std::string>{};
  const auto block = std::ranges::find(e.layout.blocks, e.law.averaged, &Block::name);
  std::vector<std::string> names;
  if (block == e.layout.blocks.end()) return names;
  for (const Index state : block->states) names.push_back(e.layout.states[static_cast<std::size_t>(state)]);
  return names;
}

SecondMomentJudgement judge_second_moments(const Evidence& e, const StretchAverages& stretches,
                                           double confidence) {
  SecondMomentJudgement result;
  result.of = e.law.averaged;
  result.of_stretches =
      stretches.averages.count > 0 && e.law.stretch_moments.of_runs(std::ssize(e.whole_runs.nees)).runs() > 0;
  const SecondMoments moments = moments_tested(e, result);
  result.test = test_second_moments(moments, confidence);
  if (!result.test.reason.empty()) return result;
  const Index dim = moments.dim();
  if (dim == 1) result.test.reason = "one state: the same as the mean of NEES";
  if (result.test.runs < kFewestRuns)
    result.test.reason = "fewer than 20 runs, and no stretches of them that are independent";
  const std::vector<std::string> names = averaged_states(e);
  const auto in_words = [&](const SecondMomentDirection& d) -> std::string {
    if (d.p >= std::ssize(names) || d.q >= std::ssize(names)) return "";
    const std::string& p = names[static_cast<std::size_t>(d.p)];
    const std::string& q = names[static_cast<std::size_t>(d.q)];
    return d.sign == 0 ? p : fmt::format("{} with {}", p, q);
  };
  result.worst = in_words(result.test.worst_direction);
  result.most_optimistic = in_words(result.test.most_optimistic);
  result.most_pessimistic = in_words(result.test.most_pessimistic);
  return result;
}

ErrorMeanJudgement judge_error_mean(const Evidence& e) {
  ErrorMeanJudgement result{.test = test_zero_mean(e.law.error_means), .largest = {}};
  const std::vector<std::string> names = averaged_states(e);
  Index largest = 0;
  if (result.test.mean.size() > 0) result.test.mean.cwiseAbs().maxCoeff(&largest);
  if (largest < std::ssize(names)) result.largest = names[static_cast<std::size_t>(largest)];
  return result;
}

/// Of what is new in each error of few runs, whatever the scale of P; else of NEES, of runs or, where they
/// have stretches that are independent, of pieces of them.
double tail_p_value_of_few(const Evidence& e, double dof, bool stretches) {
  const std::vector<Matrix>& samples = e.whole_runs.samples;
  const std::vector<std::vector<double>> residuals = residual_nees(samples, e.whole_runs.log_variances);
  if (!residuals.empty())
    return heavy_tail_p_value(tails_of_pieces(residuals, static_cast<double>(samples.front().rows())));
  return stretches ? heavy_tail_p_value(tails_of_pieces(e.whole_runs.nees, dof))
                   : heavy_tail_p_value(e.law.nees_tails);
}

/// Of the NIS of each sensor, whatever the scale of S.
double nis_tail_p_value(const std::vector<SensorSums>& sensors) {
  SmallestPValue tails;
  for (const SensorSums& sensor : sensors) {
    if (sensor.by_dimension.size() != 1) continue;
    const auto dof = static_cast<double>(sensor.by_dimension.begin()->first);
    tails.add(heavy_tail_p_value(tails_of_pieces(series_of(sensor.nis, sensor.nis.size()).moments, dof)));
  }
  return tails.adjusted();
}

/// That NEES, or NIS, is too large at some place. Heavy tails may be missing at one by chance, and what is
/// left is too small.
double too_large_p_value(std::span<const SkewedMoments> places) {
  SmallestPValue p_values;
  for (const SkewedMoments& place : places) {
    if (place.count >= kFewestRunsCompared) p_values.add(run_mean_p_values(place, 1.0).optimistic);
  }
  return p_values.adjusted();
}

/// Of components two by two, where S claims to know how they go together.
std::span<const Moments> pairs_of(const SensorSums& sensor) {
  if (sensor.varies || sensor.sensor.variances_alone) return {};
  return sensor.pairs;
}

/// That independent values have this mean: Student's t. NaN of few, which say little.
double mean_p_value(const Moments& values, double expected) {
  if (values.count < kFewestValues) return kNaN;
  const auto count = static_cast<double>(values.count);
  const double t = (values.mean - expected) / std::sqrt(values.variance() / count);
  return student_two_sided_p_value(t, count - 1.0);
}

/// A p-value that has to be smaller by kMoreForSkewed.
double of_skewed(double p_value) {
  return std::isnan(p_value) ? kNaN : std::min(1.0, kMoreForSkewed * p_value);
}

/// Tests that P is right on average which need no law.
struct MomentTests {
  SmallestPValue p_values{};
  double relative_error = 0.0;  ///< the largest of mean NEES and mean NIS

  /// Of NEES or NIS over their dof, averaged over units.
  void add(const SkewedMoments& units) {
    p_values.add(two_sided(units));
    add_error(static_cast<double>(units.count), units.mean, units.variance());
  }
  /// Of independent values.
  void add(const Moments& values, double expected) {
    if (values.count < kFewestValues) return;
    p_values.add(mean_p_value(values, expected));
    add_error(static_cast<double>(values.count), values.mean, values.variance());
  }
  void add(const DirectedPValues& p_value) {
    p_values.add(std::min(p_value.optimistic, p_value.pessimistic));
  }

 private:
  void add_error(double count, double mean, double variance) {
    if (count > 0.0) relative_error = std::max(relative_error, std::sqrt(variance / count) / mean);
  }
};

/// Of a study of many runs: the units are these, and the runs at each step.
MomentTests moments_of_many(const Evidence& e, const StudyStatistics& all,
                            const SecondMomentJudgement& second) {
  MomentTests tests;
  tests.add(all.nees_of_runs.moments);
  tests.add(e.law.nis_of_runs);
  for (const SensorSums& sensor : e.sensors) {
    for (const Moments& component : sensor.components)
      tests.p_values.add(of_skewed(mean_p_value(component, 1.0)));
    for (const Moments& pair : pairs_of(sensor)) tests.p_values.add(of_skewed(mean_p_value(pair, 1.0)));
  }
  for (const BlockSums& block : e.blocks) tests.p_values.add(two_sided(block.runs.moments));
  if (second.test.reason.empty()) tests.add(second.test.p_value);
  tests.p_values.add(step_profile_p_value(e.whole_runs.nees));
  const LeastPValue steps = least_run_mean_p_value(e.law.nis_at, 1.0, kFewestRuns);
  if (steps.tests > 0) tests.p_values.add(of_skewed(steps.p_value * static_cast<double>(steps.tests)));
  return tests;
}

/// That each of the runs is as it is all along; Bonferroni over them.
double modulation_of_runs(std::span<const std::vector<double>> runs) {
  SmallestPValue p_values;
  for (const std::vector<double>& run : runs) p_values.add(modulation(run).p_value);
  return p_values.adjusted();
}

/// Of few runs: the units are their stretches, of errors, and each NIS. None where there is a truth and no
/// stretch that is long enough.
MomentTests moments_of_few(const Evidence& e, const StudyStatistics& all, const SecondMomentJudgement& second,
                           const FewRuns& few) {
  MomentTests tests;
  if (e.has_truth) {
    const StretchAverages& stretches = few.state;
    if (stretches.averages.count == 0 || second.test.runs < kFewestRuns) return tests;
    tests.add(stretches.averages);
    tests.add(second.test.p_value);
    tests.p_values.add(step_profile_p_value(e.whole_runs.nees, stretches_of_each(e.whole_runs.nees.size())));
    const auto by_place = averages_by_place(e.whole_runs.nees, stretches.correlation_time);
    tests.p_values.add(two_sided(by_place.front()));
    tests.p_values.add(too_large_p_value(std::span(by_place).subspan(1)));
    // What takes back "not Gaussian" may be false where NEES has several memories.
    if (!std::isnan(constant_dof(all))) tests.p_values.add(modulation_of_runs(e.whole_runs.nees));
    tests.p_values.add(few.nees_over_time);
  }
  for (const SensorSums& sensor : e.sensors) {
    for (const auto& [dof, nis] : sensor.by_dimension) tests.add(nis.value, static_cast<double>(dof));
    for (const Moments& component : sensor.components) tests.add(component, 1.0);
    for (const Moments& pair : pairs_of(sensor)) tests.add(pair, 1.0);
    const std::vector<double> nis = normalised_nis(sensor);
    const auto by_place = averages_by_place(std::span(&nis, 1), 1.0);
    tests.p_values.add(too_large_p_value(std::span(by_place).subspan(1)));
  }
  for (const double p : few.nis_over_time) tests.p_values.add(p);
  return tests;
}

GaussianityJudgement judge_gaussianity(const Evidence& e, const StudyStatistics& all,
                                       const SecondMomentJudgement& second, double claimed_sigma,
                                       const FewRuns& few_runs) {
  GaussianityJudgement g;
  const bool few = e.study.runs < kFewestRuns;
  g.nees_tail_p_value = few ? tail_p_value_of_few(e, constant_dof(all), few_runs.state.averages.count > 0)
                            : heavy_tail_p_value(e.law.nees_tails);
  g.nis_tail_p_value = few ? nis_tail_p_value(e.sensors) : heavy_tail_p_value(e.law.nis_tails);
  SmallestPValue far;
  for (const SensorSums& sensor : e.sensors) {
    if (sensor.far_tail.total > 0) far.add(far_tail_p_value(sensor.far_tail, SensorSums::kFarTail));
  }
  g.far_nis_p_value = far.adjusted();
  SmallestPValue tails;
  for (const double p : {g.nees_tail_p_value, g.nis_tail_p_value, g.far_nis_p_value}) tails.add(p);
  g.tail_p_value = tails.adjusted();
  MomentTests tests = few ? moments_of_few(e, all, second, few_runs) : moments_of_many(e, all, second);
  g.relative_error = tests.relative_error;
  if (!std::isnan(tests.p_values.adjusted())) tests.p_values.add(claimed_sigma);
  g.moments_p_value = tests.p_values.adjusted();
  return g;
}

/// Of the state, the blocks and NIS; of few runs those of their stretches, of NIS for each sensor.
std::vector<SkewedMoments> means_to_prove(const Evidence& e, const StudyStatistics& all, const FewRuns& few) {
  std::vector<SkewedMoments> means;
  const bool stretches = e.study.runs < kFewestRuns;
  if (e.has_truth && e.joint_covariance)
    means.push_back(stretches ? few.state.averages : all.nees_of_runs.moments);
  for (std::size_t b = 0; b < e.blocks.size(); ++b) {
    if (e.blocks[b].runs.moments.count > 0)
      means.push_back(stretches ? few.block(b) : e.blocks[b].runs.moments);
  }
  if (!stretches && e.law.nis_of_runs.count > 0) means.push_back(e.law.nis_of_runs);
  for (std::size_t i = 0; stretches && i < e.sensors.size(); ++i) {
    const std::vector<double> nis = normalised_nis(e.sensors[i]);
    if (!nis.empty()) means.push_back(stretch_averages(std::span(&nis, 1)).averages);
  }
  return means;
}

EquivalenceJudgement judge_equivalence(const Evidence& e, const StudyStatistics& all, double confidence,
                                       double margin, const FewRuns& few) {
  EquivalenceJudgement result{.margin = margin};
  const std::vector<SkewedMoments> means = means_to_prove(e, all, few);
  if (means.empty()) result.reason = "no data";
  double largest = 0.0, within = 0.0;
  for (const SkewedMoments& mean : means) {
    const double p = equivalence_p_value(mean, margin);
    if (mean.count < kFewestRuns) {
      result.reason =
          "fewer than 20 runs, and no stretches of them that are independent, prove nothing near 1";
    } else if (std::isnan(p)) {
      result.reason = "a mean is not a number";
    }
    largest = std::max(largest, p);
    within = std::max(within, proved_within(mean, confidence));
  }
  if (!result.reason.empty()) return result;
  result.p_value = largest;
  result.proved_within = within;
  return result;
}

ScoreJudgement judge_score(const ScoreMoments& score, double confidence) {
  ScoreJudgement result;
  if (score.value.count == 0) {
    result.reason = "no run with a P of full rank over the whole state";
    return result;
  }
  result.value = hall_interval(score.value, confidence);
  result.reason = result.value.reason;
  result.expected = score.expected.mean;
  return result;
}

/// Of these states, that are rows of the samples.
NeesOverTime of_runs_over_time(const RunSums& runs, const std::vector<Index>& states) {
  NeesOverTime result;
  SmallestPValue p_values;
  for (std::size_t i = 0; i < runs.samples.size(); ++i) {
    const Modulation of_run = error_modulation(runs.samples[i](states, Eigen::all));
    p_values.add(of_run.p_value);
    if (!(of_run.p_value >= result.p_value) && !std::isnan(of_run.p_value)) {
      const auto values = static_cast<double>(runs.samples[i].cols());
      static_cast<Modulation&>(result) = of_run;
      result.wave *= std::round(static_cast<double>(runs.nees[i].size()) / values);
    }
  }
  result.p_value = p_values.adjusted();
  return result;
}

}  // namespace

double constant_dof(const StudyStatistics& s) {
  double values = 0.0, dof = 0.0;
  for (const Moments& step : s.series(Quantity::nees)) values += static_cast<double>(step.count);
  for (const double of_step : s.dofs(Quantity::nees)) dof += of_step;
  const auto least = static_cast<double>(s.nees_of_runs.least_dof);
  return values > 0.0 && dof == least * values ? least : kNaN;
}

std::vector<NeesOverTime> nees_over_time(const Evidence& e) {
  const RunSums& runs = e.whole_runs;
  if (!e.joint_covariance || runs.nees.empty() || runs.samples.size() != runs.nees.size()) return {};
  const Index dim = runs.samples.front().rows();
  if (!std::ranges::all_of(runs.samples, [dim](const Matrix& of_run) { return of_run.rows() == dim; }))
    return {};
  std::vector<NeesOverTime> tested;
  const auto test = [&](const std::string& of, const std::vector<Index>& states) {
    NeesOverTime part = of_runs_over_time(runs, states);
    part.of = of;
    if (!std::isnan(part.p_value)) tested.push_back(std::move(part));
  };
  std::vector<Index> all(static_cast<std::size_t>(dim));
  std::iota(all.begin(), all.end(), Index{0});
  if (dim != e.state_dim) {
    const Index lead = lead_block(e.layout);
    if (lead >= 0) test(e.layout.blocks[static_cast<std::size_t>(lead)].name, all);
    return tested;
  }
  test("", all);
  for (const Block& block : e.layout.blocks) {
    const auto is_there = [dim](Index state) { return state < dim; };
    if (std::ssize(block.states) < dim && std::ranges::all_of(block.states, is_there))
      test(block.name, block.states);
  }
  return tested;
}

std::vector<double> normalised_nis(const SensorSums& sensor) {
  std::vector<double> means;
  for (const StepSums& step : sensor.nis) {
    if (step.dof > 0)
      means.push_back(step.value.mean * static_cast<double>(step.value.count) /
                      static_cast<double>(step.dof));
  }
  return means;
}

Modulation nis_over_time(const SensorSums& sensor) {
  std::int64_t runs = 0;
  for (const StepSums& step : sensor.nis) runs = std::max(runs, step.value.count);
  if (sensor.by_dimension.size() != 1 || runs >= kFewestRuns) return {};
  std::vector<double> means;
  for (const StepSums& step : sensor.nis) {
    if (step.value.count == runs) means.push_back(step.value.mean);
  }
  return modulation(means);
}

SecondMoments moments_tested(const Evidence& e, const SecondMomentJudgement& judged) {
  return judged.of_stretches ? e.law.stretch_moments.of_runs(std::ssize(e.whole_runs.nees))
                             : e.law.second_moments;
}

LawJudgement judge_law(const Evidence& e, const StudyStatistics& all_runs, double confidence, double margin,
                       double claimed_sigma, const FewRuns& few) {
  LawJudgement j;
  j.shape = judge_shape(e.law, confidence);
  j.second_moments = judge_second_moments(e, few.state, confidence);
  j.error_mean = judge_error_mean(e);
  j.gaussianity = judge_gaussianity(e, all_runs, j.second_moments, claimed_sigma, few);
  j.equivalence = judge_equivalence(e, all_runs, confidence, margin, few);
  j.log_score = judge_score(e.scores.log, confidence);
  j.energy_score = judge_score(e.scores.energy, confidence);
  j.energy_of_position = e.scores.of_position;
  for (const SensorPairSums& pair : e.sensor_pairs) {
    j.sensor_pairs.push_back({pair.first, pair.second, test_block_correlation(pair.both, pair.first_dim)});
  }
  return j;
}

}  // namespace credence::internal
