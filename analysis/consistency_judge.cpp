#include "analysis/consistency_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>

#include "analysis/chi_square_dependent_sum.h"

namespace credence {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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

// The law and the bounds of a step: most steps share dof and count, so the last ones are kept.
class StepTester {
 public:
  StepTester(const VerdictLaws& laws, double confidence, double simultaneous_confidence)
      : laws_(laws), confidence_(confidence), simultaneous_confidence_(simultaneous_confidence) {}

  StepTest test(const Moments& moments, double dof) {
    const double count = static_cast<double>(moments.count);
    prepare(dof, count);
    StepTest step;
    step.mean = moments.mean;
    step.expected = law_.expected / count;
    step.lower = pointwise_.lower / count;
    step.upper = pointwise_.upper / count;
    step.simultaneous_lower = simultaneous_.lower / count;
    step.simultaneous_upper = simultaneous_.upper / count;
    step.p_value = law_.p_value(count * moments.mean);
    step.count = moments.count;
    step.total_dof = dof;
    step.outside = step.mean < step.lower || step.mean > step.upper;
    return step;
  }

 private:
  void prepare(double dof, double count) {
    if (dof == dof_ && count == count_) return;
    dof_ = dof;
    count_ = count;
    law_ = laws_.step(dof, count);
    pointwise_ = law_.bounds(confidence_);
    simultaneous_ = law_.bounds(simultaneous_confidence_);
  }

  const VerdictLaws& laws_;
  double confidence_, simultaneous_confidence_;
  double dof_ = 0.0;
  double count_ = 0.0;
  SumLaw law_;
  ChiSquareBounds pointwise_, simultaneous_;
};

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

void add_steps(std::span<const Moments> per_step, std::span<const double> dofs, const VerdictLaws& laws,
               ConsistencyVerdict& result) {
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (per_step[k].count > 0 && dofs[k] > 0.0) ++result.steps_tested;
  }
  result.steps_without_data = static_cast<std::int64_t>(dofs.size()) - result.steps_tested;
  const double level = level_of_part(result.confidence, result.steps_tested);
  const double tests = static_cast<double>(std::max<std::int64_t>(1, result.steps_tested));
  StepTester tester(laws, result.confidence, 1.0 - level / tests);
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    const bool data = per_step[k].count > 0 && dofs[k] > 0.0;
    result.steps.push_back(data ? tester.test(per_step[k], dofs[k])
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
  if (result.steps_tested == 0) return;
  double sum = 0.0;
  double expected = 0.0;
  double smallest = 2.0;
  std::int64_t outside = 0;
  for (std::size_t k = 0; k < result.steps.size(); ++k) {
    const StepTest& step = result.steps[k];
    if (!has_data(step)) continue;
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

void test_overall(const VerdictLaws& laws, ConsistencyVerdict& result) {
  std::vector<StepTest> tested;
  for (const StepTest& step : result.steps) {
    if (has_data(step)) tested.push_back(step);
  }
  const double count = static_cast<double>(result.count);
  // One step is one sum whatever the dependence between steps.
  const SumLaw law = tested.size() == 1 ? laws.step(result.dof, count) : laws.overall(tested);
  const ChiSquareBounds bounds = law.bounds(1.0 - level_of_part(result.confidence, result.steps_tested));
  result.bounds = {bounds.lower / count, bounds.upper / count};
  result.overall_p_value = law.p_value(count * result.mean);
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

}  // namespace

SumLaw chi_square_law(double dof) {
  return {.expected = dof,
          .bounds = [dof](double confidence) { return mean_bounds(dof, 1.0, confidence); },
          .p_value = [dof](double sum) { return two_sided_p_value(sum, dof); }};
}

SumLaw dependent_law(std::vector<double> dofs) {
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
  result.mean = result.expected = result.p_value = kNaN;
  result.overall_p_value = result.steps_p_value = kNaN;
  result.bounds = {kNaN, kNaN};
  add_steps(per_step, total_dof_per_step, laws, result);
  summarise_steps(result);
  result.reason = reason_not_to_judge(result);
  if (!result.reason.empty()) return result;
  test_overall(laws, result);
  conclude(result);
  return result;
}

}  // namespace credence
