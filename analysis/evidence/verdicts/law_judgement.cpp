#include "analysis/evidence/verdicts/law_judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/laws/mean/equivalence.h"
#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/shape/tail_weight.h"

namespace credence::internal {
namespace {

/// With fewer runs a mean over them says little without a law.
constexpr std::int64_t kFewestRuns = 20;

/// So far in the tails, the skewness of a few heavy-tailed values is not all removed.
constexpr double kMoreForSteps = 10.0;

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

SecondMomentJudgement judge_second_moments(const Evidence& e, double confidence) {
  SecondMomentJudgement result;
  result.of = e.law.averaged;
  result.test = test_second_moments(e.law.second_moments, confidence);
  if (!result.test.reason.empty()) return result;
  const Index dim = e.law.second_moments.dim();
  if (dim == 1) result.test.reason = "one state: the same as the mean of NEES";
  if (result.test.runs < kFewestRuns) result.test.reason = "fewer than 20 runs";
  const std::vector<std::string> names = averaged_states(e);
  const SecondMomentDirection& d = result.test.worst_direction;
  if (d.p >= std::ssize(names) || d.q >= std::ssize(names)) return result;
  const std::string& p = names[static_cast<std::size_t>(d.p)];
  const std::string& q = names[static_cast<std::size_t>(d.q)];
  result.worst = d.sign == 0 ? p : fmt::format("{} with {}", p, q);
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

GaussianityJudgement judge_gaussianity(const Evidence& e, const StudyStatistics& all,
                                       const SecondMomentJudgement& second, double claimed_sigma) {
  GaussianityJudgement g;
  g.nees_tail_p_value = heavy_tail_p_value(e.law.nees_tails);
  g.nis_tail_p_value = heavy_tail_p_value(e.law.nis_tails);
  SmallestPValue far;
  for (const SensorSums& sensor : e.sensors) {
    if (sensor.far_tail.total > 0) far.add(far_tail_p_value(sensor.far_tail, SensorSums::kFarTail));
  }
  g.far_nis_p_value = far.adjusted();
  SmallestPValue tails;
  for (const double p : {g.nees_tail_p_value, g.nis_tail_p_value, g.far_nis_p_value}) tails.add(p);
  g.tail_p_value = tails.adjusted();
  if (e.study.runs < kFewestRuns) return g;

  for (const SkewedMoments& runs : {all.nees_of_runs.moments, e.law.nis_of_runs}) {
    if (runs.count == 0) continue;
    const double error = std::sqrt(runs.variance() / static_cast<double>(runs.count)) / runs.mean;
    g.relative_error = std::max(g.relative_error, error);
  }
  SmallestPValue moments;
  moments.add(two_sided(all.nees_of_runs.moments));
  moments.add(two_sided(e.law.nis_of_runs));
  for (const BlockSums& block : e.blocks) moments.add(two_sided(block.runs.moments));
  if (second.test.reason.empty())
    moments.add(std::min(second.test.p_value.optimistic, second.test.p_value.pessimistic));
  moments.add(claimed_sigma);
  for (const std::vector<SkewedMoments>* series : {&e.law.nees_at, &e.law.nis_at}) {
    SmallestPValue steps;
    for (const SkewedMoments& step : *series) steps.add(two_sided(step));
    moments.add(std::min(1.0, kMoreForSteps * steps.adjusted()));
  }
  g.moments_p_value = moments.adjusted();
  return g;
}

EquivalenceJudgement judge_equivalence(const Evidence& e, const StudyStatistics& all, double confidence,
                                       double margin) {
  EquivalenceJudgement result{.margin = margin};
  std::vector<const SkewedMoments*> parts;
  if (e.has_truth && e.joint_covariance) parts.push_back(&all.nees_of_runs.moments);
  for (const BlockSums& block : e.blocks) parts.push_back(&block.runs.moments);
  parts.push_back(&e.law.nis_of_runs);
  double largest = 0.0, within = 0.0;
  std::int64_t made = 0;
  for (const SkewedMoments* part : parts) {
    if (part->count == 0) continue;
    if (part->count < kFewestRuns) {
      result.reason = "fewer than 20 runs prove nothing near 1";
      return result;
    }
    const double p = equivalence_p_value(*part, margin);
    if (std::isnan(p)) continue;
    ++made;
    largest = std::max(largest, p);
    within = std::max(within, proved_within(*part, confidence));
  }
  if (made == 0) {
    result.reason = "no data";
    return result;
  }
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

}  // namespace

LawJudgement judge_law(const Evidence& e, const StudyStatistics& all_runs, double confidence, double margin,
                       double claimed_sigma) {
  LawJudgement j;
  j.shape = judge_shape(e.law, confidence);
  j.second_moments = judge_second_moments(e, confidence);
  j.error_mean = judge_error_mean(e);
  j.gaussianity = judge_gaussianity(e, all_runs, j.second_moments, claimed_sigma);
  j.equivalence = judge_equivalence(e, all_runs, confidence, margin);
  j.log_score = judge_score(e.scores.log, confidence);
  j.energy_score = judge_score(e.scores.energy, confidence);
  j.energy_of_position = e.scores.of_position;
  for (const SensorPairSums& pair : e.sensor_pairs) {
    j.sensor_pairs.push_back({pair.first, pair.second, test_block_correlation(pair.both, pair.first_dim)});
  }
  return j;
}

}  // namespace credence::internal
