#include "analysis/evidence/verdicts/consistency_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square_dependent_sum.h"
#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/require.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

void require_input(std::span<const Moments> per_step, std::span<const double> dofs, double confidence) {
  if (per_step.size() != dofs.size()) {
    throw std::invalid_argument(
        fmt::format("{} steps of moments but {} steps of dof", per_step.size(), dofs.size()));
  }
  require_confidence(confidence);
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (!(std::isfinite(dofs[k]) && dofs[k] >= 0.0)) {
      throw std::invalid_argument(
          fmt::format("total dof = {} of step {} must be a finite number >= 0", dofs[k], k));
    }
    if (per_step[k].count < 0) {
      throw std::invalid_argument(fmt::format("count = {} of step {} is negative", per_step[k].count, k));
    }
  }
}

// Values that are rounded in the log, such as an error of 0.00, are where no law with a density has any, and
// mean no small variance. So few degrees of freedom cannot show a variance too small at one step anyway: at a
// level of 1e-4 one that is a hundred times too large goes unseen in 99 of 100 steps of two.
bool tells_too_small(const StepTest& step) {
  constexpr double kFewDof = 2.0;
  constexpr std::int64_t kFewRuns = 5;
  return step.total_dof > kFewDof && (step.mean > 0.0 || step.count >= kFewRuns);
}

StepTest step_without_data(const Moments& moments, double dof) {
  StepTest step;
  step.mean = step.expected = step.lower = step.upper = kNaN;
  step.simultaneous_lower = step.simultaneous_upper = step.p_value = kNaN;
  step.count = moments.count;
  step.total_dof = dof;
  return step;
}

// Most steps share dof and count: the last law and its bounds are kept.
class StepLaw {
 public:
  StepLaw(const VerdictLaws& laws, double confidence) : laws_(laws), confidence_(confidence) {}

  void prepare(const StepTest& step) {
    const double count = static_cast<double>(step.count);
    if (step.total_dof == dof_ && count == count_) return;
    dof_ = step.total_dof;
    count_ = count;
    law = laws_.step(dof_, count_);
    bounds = law.bounds(confidence_);
  }

  SumLaw law;
  ChiSquareBounds bounds;

 private:
  const VerdictLaws& laws_;
  double confidence_;
  double dof_ = 0.0;
  double count_ = 0.0;
};

void test_step(StepLaw& law, StepTest& step) {
  law.prepare(step);
  const double count = static_cast<double>(step.count);
  step.expected = law.law.expected / count;
  step.lower = law.bounds.lower / count;
  step.upper = law.bounds.upper / count;
  step.p_value =
      step.mean > step.expected || tells_too_small(step) ? law.law.p_value(count * step.mean) : 1.0;
  step.outside = step.mean < step.lower || step.mean > step.upper;
}

// How the tests of a verdict are joined: the level of each, and the adjusted p-value.
struct Joint {
  double step_level = 0.0;
  double overall_level = 0.0;
  std::function<double(double smallest_step, double overall)> p_value;
};

Joint union_bound(double alpha, double steps) {
  return {.step_level = alpha / (2.0 * steps),
          .overall_level = alpha / 2.0,
          .p_value = [steps](double smallest_step, double overall) {
            return std::min(1.0, 2.0 * std::min(overall, steps * smallest_step));
          }};
}

// A single step is also the sum, and is tested once.
Joint single_test(double alpha) {
  return {
      .step_level = alpha, .overall_level = alpha, .p_value = [](double, double overall) { return overall; }};
}

// Holm's step-down procedure: the i-th smallest p-value (from 0) is compared with α / (T − i).
std::int64_t count_holm_rejections(const std::vector<StepTest>& steps, double alpha) {
  std::vector<double> p_values;  // those that may be rejected
  std::size_t tests = 0, rejected = 0;
  for (const StepTest& step : steps) {
    if (!step.has_data()) continue;
    ++tests;
    if (step.p_value <= alpha) p_values.push_back(step.p_value);
  }
  std::ranges::sort(p_values);
  while (rejected < p_values.size() && p_values[rejected] <= alpha / static_cast<double>(tests - rejected)) {
    ++rejected;
  }
  return static_cast<std::int64_t>(rejected);
}

void add_steps(std::span<const Moments> per_step, std::span<const double> dofs, ConsistencyVerdict& result) {
  result.steps.reserve(dofs.size());
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    StepTest step = step_without_data(per_step[k], dofs[k]);
    if (step.has_data()) {
      step.mean = per_step[k].mean;
      ++result.steps_tested;
    } else {
      ++result.steps_without_data;
    }
    result.steps.push_back(step);
  }
}

// Empty if the data can be judged.
std::string reason_not_to_judge(const ConsistencyVerdict& result) {
  if (result.steps_tested == 0) return "no data: no step has both runs and degrees of freedom";
  for (std::size_t k = 0; k < result.steps.size(); ++k) {
    const StepTest& step = result.steps[k];
    if (!step.has_data()) continue;
    if (std::isnan(step.mean)) return fmt::format("the mean of step {} is not a number", k + 1);
    if (step.mean < 0.0) return fmt::format("the mean {} of step {} is negative", step.mean, k + 1);
  }
  return {};
}

std::vector<StepTest> tested_steps(const ConsistencyVerdict& result) {
  std::vector<StepTest> tested;
  std::ranges::copy_if(result.steps, std::back_inserter(tested), &StepTest::has_data);
  return tested;
}

Joint join(const ConsistencyVerdict& result) {
  const double alpha = 1.0 - result.confidence;
  if (result.steps_tested == 1) return single_test(alpha);
  return union_bound(alpha, static_cast<double>(result.steps_tested));
}

void test_steps(const VerdictLaws& laws, double simultaneous_level, ConsistencyVerdict& result) {
  StepLaw pointwise(laws, result.confidence);
  StepLaw simultaneous(laws, 1.0 - simultaneous_level);
  for (StepTest& step : result.steps) {
    if (!step.has_data()) continue;
    test_step(pointwise, step);
    simultaneous.prepare(step);
    const double count = static_cast<double>(step.count);
    step.simultaneous_lower = tells_too_small(step) ? simultaneous.bounds.lower / count : 0.0;
    step.simultaneous_upper = simultaneous.bounds.upper / count;
  }
}

void summarise_steps(ConsistencyVerdict& result) {
  double sum = 0.0;
  double expected = 0.0;
  double smallest = 2.0;
  std::int64_t outside = 0;
  for (std::size_t k = 0; k < result.steps.size(); ++k) {
    const StepTest& step = result.steps[k];
    if (!step.has_data()) continue;
    sum += static_cast<double>(step.count) * step.mean;
    expected += static_cast<double>(step.count) * step.expected;
    result.dof += step.total_dof;
    result.count += step.count;
    outside += step.outside ? 1 : 0;
    if (step.p_value < smallest) {
      smallest = step.p_value;
      result.worst_step = static_cast<std::int64_t>(k);
    }
  }
  result.mean = sum / static_cast<double>(result.count);
  result.expected = expected / static_cast<double>(result.count);
  result.share_outside = static_cast<double>(outside) / static_cast<double>(result.steps_tested);
  result.steps_p_value = std::min(1.0, smallest * static_cast<double>(result.steps_tested));
  result.steps_rejected = count_holm_rejections(result.steps, 1.0 - result.confidence);
}

/// Whether no run failed and they have nearly as many steps each, so that the mean over them is that over all
/// values.
bool are_alike(const RunAverages& runs, const ConsistencyVerdict& result) {
  constexpr double kMissing = 0.05;
  std::int64_t most = 0;
  for (const StepTest& step : result.steps) most = std::max(most, step.count);
  const auto of_all = static_cast<double>(most) * static_cast<double>(result.steps_tested);
  return most <= runs.moments.count && static_cast<double>(result.count) >= (1.0 - kMissing) * of_all;
}

/// Bounds of the mean that the interval of the factor accepts: those between which 1 lies in it. Of runs of
/// different lengths each counts once, in the mean as in its test, and none that failed.
void test_runs(const RunAverages& runs, double level, ConsistencyVerdict& result) {
  const auto least_dof = static_cast<double>(runs.least_dof);
  const MeanInterval decides = run_mean_interval(runs.moments, 1.0 - level, least_dof);
  if (!are_alike(runs, result)) result.mean = result.expected * decides.mean;
  result.bounds = {result.mean / decides.upper, result.mean / decides.lower};
  result.overall_p_value = run_mean_p_values(runs.moments, 1.0, least_dof).two_sided();
}

void test_overall(const VerdictLaws& laws, double level, ConsistencyVerdict& result) {
  // Errors that are all exactly zero have no scale, and no interval of it.
  if (laws.runs != nullptr && laws.runs->moments.mean > 0.0) {
    result.factor =
        run_mean_interval(laws.runs->moments, result.confidence, static_cast<double>(laws.runs->least_dof));
    if (result.steps_tested > 1) return test_runs(*laws.runs, level, result);
  }
  const double count = static_cast<double>(result.count);
  // One step is one sum whatever the dependence between steps.
  const SumLaw law =
      result.steps_tested == 1 ? laws.step(result.dof, count) : laws.overall(tested_steps(result));
  const ChiSquareBounds bounds = law.bounds(1.0 - level);
  result.bounds = {bounds.lower / count, bounds.upper / count};
  result.overall_p_value = law.p_value(count * result.mean);
}

/// What one direction says: its smallest p-value, adjusted.
struct Direction {
  double step = 1.0;     ///< smallest p-value of a step
  double overall = 1.0;  ///< of the overall test
};

void conclude(const Joint& joint, bool runs, ConsistencyVerdict& result) {
  const double alpha = 1.0 - result.confidence;
  Direction up, down;
  for (std::size_t k = 0; k < result.steps.size(); ++k) {
    const StepTest& step = result.steps[k];
    if (!step.has_data()) continue;
    const bool high = step.mean > step.expected;
    Direction& direction = high ? up : down;
    direction.step = std::min(direction.step, step.p_value);
    if (step.p_value <= joint.step_level) {
      (high ? result.optimistic_steps : result.pessimistic_steps).add(static_cast<std::int64_t>(k) + 1);
    }
  }
  // Of a single step its own test stands for all.
  const bool by_runs = runs && result.steps_tested > 1;
  const bool mean_high = by_runs ? result.factor.mean > 1.0 : result.mean > result.expected;
  // Averages of runs too large for their powers have no test; NaN would hide what the steps say.
  const double overall = std::isnan(result.overall_p_value) ? 1.0 : result.overall_p_value;
  (mean_high ? up : down).overall = overall;
  result.tests = result.steps_tested + (result.steps_tested == 1 ? 0 : 1);
  result.optimistic_p_value = joint.p_value(up.step, up.overall);
  result.pessimistic_p_value = joint.p_value(down.step, down.overall);
  result.p_value = std::min(result.optimistic_p_value, result.pessimistic_p_value);
  const double smallest = std::min(up.step, down.step);
  result.decided_by_steps =
      result.steps_tested > 1 && overall * joint.step_level > smallest * joint.overall_level;
  const bool optimistic = result.optimistic_p_value <= alpha,
             pessimistic = result.pessimistic_p_value <= alpha;
  result.verdict = direction_of(optimistic, pessimistic);
}

}  // namespace

SumLaw chi_square_law(double dof) {
  return {.expected = dof,
          .bounds = [dof](double confidence) { return mean_bounds(dof, 1.0, confidence); },
          .p_value = [dof](double sum) { return two_sided_p_value(sum, dof); }};
}

SumLaw dependent_law(const std::vector<double>& dofs) {
  double expected = 0.0;
  for (const double dof : dofs) expected += dof;
  return {.expected = expected,
          .bounds = [dofs](double confidence) { return dependent_sum_bounds(dofs, confidence); },
          .p_value = [dofs](double sum) { return dependent_sum_p_value(sum, dofs); }};
}

SumLaw cumulant_law(const Cumulants& cumulants) {
  return {.expected = cumulants.mean,
          .bounds = [cumulants](double confidence) { return sum_bounds(cumulants, confidence); },
          .p_value = [cumulants](double sum) { return two_sided_p_value(sum, cumulants); }};
}

ConsistencyVerdict judge_sums(std::span<const Moments> per_step, std::span<const double> total_dof_per_step,
                              double confidence, const VerdictLaws& laws) {
  require_input(per_step, total_dof_per_step, confidence);
  ConsistencyVerdict result;
  result.confidence = confidence;
  result.expected_share_outside = 1.0 - confidence;
  result.method = laws.method;
  result.mean = result.expected = result.p_value = result.share_outside = kNaN;
  result.overall_p_value = result.steps_p_value = kNaN;
  result.factor.mean = result.factor.lower = result.factor.upper = kNaN;
  result.factor.reason = "the averages of whole runs are not known";
  result.bounds = {kNaN, kNaN};
  add_steps(per_step, total_dof_per_step, result);
  result.reason = reason_not_to_judge(result);
  if (!result.reason.empty()) return result;
  const Joint joint = join(result);
  test_steps(laws, joint.step_level, result);
  summarise_steps(result);
  test_overall(laws, joint.overall_level, result);
  conclude(joint, laws.runs != nullptr, result);
  return result;
}

}  // namespace credence::internal
