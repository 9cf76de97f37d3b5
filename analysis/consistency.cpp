#include "analysis/consistency.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/chi_square_dependent_sum.h"

namespace credence {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

enum class Dependence { arbitrary, independent };

void require_input(std::span<const Moments> per_step, std::span<const double> dofs, double confidence) {
  if (per_step.size() != dofs.size()) {
    throw std::invalid_argument(
        fmt::format("{} steps of moments but {} steps of dof", per_step.size(), dofs.size()));
  }
  if (!(confidence > 0.0 && confidence < 1.0)) {
    throw std::invalid_argument(fmt::format("confidence = {} must lie in (0, 1)", confidence));
  }
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

bool has_data(const StepTest& step) { return step.count > 0 && step.total_dof > 0.0; }

StepTest step_without_data(const Moments& moments, double dof) {
  StepTest step;
  step.mean = step.expected = step.lower = step.upper = kNaN;
  step.simultaneous_lower = step.simultaneous_upper = step.p_value = kNaN;
  step.count = moments.count;
  step.total_dof = dof;
  return step;
}

// Pointwise and simultaneous bounds of a step: most steps share count and dof, so the last ones are kept.
class StepBounds {
 public:
  StepBounds(double confidence, double simultaneous_confidence)
      : confidence_(confidence), simultaneous_confidence_(simultaneous_confidence) {}

  void update(double dof, double count) {
    if (dof == dof_ && count == count_) return;
    dof_ = dof;
    count_ = count;
    pointwise = mean_bounds(dof, count, confidence_);
    simultaneous = mean_bounds(dof, count, simultaneous_confidence_);
  }

  ChiSquareBounds pointwise, simultaneous;

 private:
  double confidence_, simultaneous_confidence_;
  double dof_ = 0.0;
  double count_ = 0.0;
};

StepTest test_step(const Moments& moments, double dof, StepBounds& bounds) {
  const double count = static_cast<double>(moments.count);
  bounds.update(dof, count);
  StepTest step;
  step.mean = moments.mean;
  step.expected = dof / count;
  step.lower = bounds.pointwise.lower;
  step.upper = bounds.pointwise.upper;
  step.simultaneous_lower = bounds.simultaneous.lower;
  step.simultaneous_upper = bounds.simultaneous.upper;
  step.p_value = two_sided_p_value(count * moments.mean, dof);
  step.count = moments.count;
  step.total_dof = dof;
  step.outside = step.mean < step.lower || step.mean > step.upper;
  return step;
}

// Holm's step-down procedure: the i-th smallest p-value (from 0) is compared with α / (T − i).
std::int64_t count_holm_rejections(const std::vector<StepTest>& steps, double alpha) {
  std::vector<double> p_values;
  for (const StepTest& step : steps) {
    if (has_data(step)) p_values.push_back(step.p_value);
  }
  std::sort(p_values.begin(), p_values.end());
  std::size_t rejected = 0;
  while (rejected < p_values.size() &&
         p_values[rejected] <= alpha / static_cast<double>(p_values.size() - rejected)) {
    ++rejected;
  }
  return static_cast<std::int64_t>(rejected);
}

Verdict direction(double mean, double expected) {
  return mean > expected ? Verdict::optimistic : Verdict::pessimistic;
}

// The level of one of the two tests of a verdict: a single step is both, and is tested once.
double level_of_part(double confidence, std::int64_t steps_tested) {
  return (1.0 - confidence) / (steps_tested > 1 ? 2.0 : 1.0);
}

void add_steps(std::span<const Moments> per_step, std::span<const double> dofs, ConsistencyVerdict& result) {
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (per_step[k].count > 0 && dofs[k] > 0.0) ++result.steps_tested;
  }
  result.steps_without_data = static_cast<std::int64_t>(dofs.size()) - result.steps_tested;
  const double level = level_of_part(result.confidence, result.steps_tested);
  const double tests = static_cast<double>(std::max<std::int64_t>(1, result.steps_tested));
  StepBounds bounds(result.confidence, 1.0 - level / tests);
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    const bool data = per_step[k].count > 0 && dofs[k] > 0.0;
    result.steps.push_back(data ? test_step(per_step[k], dofs[k], bounds)
                                : step_without_data(per_step[k], dofs[k]));
  }
}

// Empty if the data can be judged.
std::string reason_not_to_judge(const ConsistencyVerdict& result) {
  if (result.steps_tested == 0) return "no data: no step has both runs and degrees of freedom";
  for (std::size_t k = 0; k < result.steps.size(); ++k) {
    const StepTest& step = result.steps[k];
    if (!has_data(step)) continue;
    if (std::isnan(step.mean)) return fmt::format("the mean of step {} is not a number", k);
    if (step.mean < 0.0) return fmt::format("the mean {} of step {} is negative", step.mean, k);
  }
  return {};
}

void summarise_steps(ConsistencyVerdict& result) {
  double sum = 0.0;
  double smallest = 2.0;
  std::int64_t outside = 0;
  for (std::size_t k = 0; k < result.steps.size(); ++k) {
    const StepTest& step = result.steps[k];
    if (!has_data(step)) continue;
    sum += static_cast<double>(step.count) * step.mean;
    result.dof += step.total_dof;
    result.count += step.count;
    outside += step.outside ? 1 : 0;
    if (step.p_value < smallest) {
      smallest = step.p_value;
      result.worst_step = static_cast<std::int64_t>(k);
    }
  }
  if (result.steps_tested == 0) return;
  result.mean = sum / static_cast<double>(result.count);
  result.expected = result.dof / static_cast<double>(result.count);
  result.share_outside = static_cast<double>(outside) / static_cast<double>(result.steps_tested);
  result.steps_p_value = std::min(1.0, smallest * static_cast<double>(result.steps_tested));
  result.steps_rejected = count_holm_rejections(result.steps, 1.0 - result.confidence);
}

void test_overall(Dependence dependence, ConsistencyVerdict& result) {
  const double confidence = 1.0 - level_of_part(result.confidence, result.steps_tested);
  const double count = static_cast<double>(result.count);
  const double sum = count * result.mean;
  // One step is one chi-square whatever the dependence between steps.
  if (dependence == Dependence::independent || result.steps_tested == 1) {
    result.bounds = mean_bounds(result.dof, count, confidence);
    result.overall_p_value = two_sided_p_value(sum, result.dof);
    return;
  }
  std::vector<double> dofs;
  for (const StepTest& step : result.steps) {
    if (has_data(step)) dofs.push_back(step.total_dof);
  }
  const ChiSquareBounds bounds = dependent_sum_bounds(dofs, confidence);
  result.bounds = {bounds.lower / count, bounds.upper / count};
  result.overall_p_value = dependent_sum_p_value(sum, dofs);
}

void conclude(ConsistencyVerdict& result) {
  const bool single = result.steps_tested == 1;
  result.tests = result.steps_tested + (single ? 0 : 1);
  result.p_value = single ? result.overall_p_value
                          : std::min(1.0, 2.0 * std::min(result.overall_p_value, result.steps_p_value));
  if (result.p_value > 1.0 - result.confidence) {
    result.verdict = Verdict::consistent;
  } else if (result.overall_p_value <= result.steps_p_value) {
    result.verdict = direction(result.mean, result.expected);
  } else {
    const StepTest& worst = result.steps[static_cast<std::size_t>(result.worst_step)];
    result.verdict = direction(worst.mean, worst.expected);
  }
}

ConsistencyVerdict judge(std::span<const Moments> per_step, std::span<const double> dofs, double confidence,
                         Dependence dependence) {
  require_input(per_step, dofs, confidence);
  ConsistencyVerdict result;
  result.confidence = confidence;
  result.expected_share_outside = 1.0 - confidence;
  result.method = dependence == Dependence::arbitrary
                      ? "every step (Bonferroni) and the sum over steps (expected-shortfall bound), "
                        "both valid for any correlation in time"
                      : "every step (Bonferroni) and the chi-square sum over runs and white steps";
  result.mean = result.expected = result.p_value = kNaN;
  result.overall_p_value = result.steps_p_value = kNaN;
  result.bounds = {kNaN, kNaN};
  add_steps(per_step, dofs, result);
  summarise_steps(result);
  result.reason = reason_not_to_judge(result);
  if (!result.reason.empty()) return result;
  test_overall(dependence, result);
  conclude(result);
  return result;
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::consistent:
      return "consistent";
    case Verdict::optimistic:
      return "optimistic";
    case Verdict::pessimistic:
      return "pessimistic";
    case Verdict::undecided:
      return "undecided";
  }
  return "undecided";
}

ConsistencyVerdict judge_nees(std::span<const Moments> per_step, std::span<const double> total_dof_per_step,
                              double confidence) {
  return judge(per_step, total_dof_per_step, confidence, Dependence::arbitrary);
}

ConsistencyVerdict judge_nis(std::span<const Moments> per_step, std::span<const double> total_dof_per_step,
                             double confidence) {
  return judge(per_step, total_dof_per_step, confidence, Dependence::independent);
}

}  // namespace credence
