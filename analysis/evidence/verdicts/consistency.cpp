#include "analysis/evidence/verdicts/consistency.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "analysis/evidence/verdicts/consistency_judge.h"
#include "analysis/laws/chi_square/chi_square_truncated.h"
#include "analysis/laws/mean/run_mean.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

SumLaw chi_square_step(double total_dof, double /*count*/) { return chi_square_law(total_dof); }

SumLaw any_correlation(const std::vector<StepTest>& tested) {
  std::vector<double> dofs;
  dofs.reserve(tested.size());
  for (const StepTest& step : tested) dofs.push_back(step.total_dof);
  return dependent_law(dofs);
}

/// Of τ times a sum of that law.
SumLaw times(double tau, SumLaw law) {
  if (tau == 1.0) return law;
  return {.expected = tau * law.expected,
          .bounds =
              [tau, bounds = std::move(law.bounds)](double confidence) {
                const ChiSquareBounds of_fewer = bounds(confidence);
                return ChiSquareBounds{tau * of_fewer.lower, tau * of_fewer.upper};
              },
          .p_value = [tau, p_value = std::move(law.p_value)](double sum) { return p_value(sum / tau); }};
}

double total_dof_of(const std::vector<StepTest>& tested) {
  double dof = 0.0;
  for (const StepTest& step : tested) dof += step.total_dof;
  return dof;
}

double total_count_of(const std::vector<StepTest>& tested) {
  double count = 0.0;
  for (const StepTest& step : tested) count += static_cast<double>(step.count);
  return count;
}

/// Of the sum over runs and steps of this correlation time.
std::string steps_text(double tau) {
  return tau == 1.0 ? "white steps"
                    : fmt::format(
                          "steps, as far as it varies for their correlation in time: {} times as much as "
                          "of white ones",
                          number_text(tau, 3));
}

}  // namespace

std::string ConsistencyVerdict::time_text(std::int64_t first, std::int64_t last) const {
  return times == nullptr ? std::string() : times->text(step_of(first), step_of(last));
}

std::string ConsistencyVerdict::text_of(const StepSpan& span) const {
  if (span.count == 0) return {};
  const std::string time = time_text(span.first, span.last);
  if (span.count == 1) return fmt::format("step {}{}", step_of(span.first), time);
  return fmt::format("steps {} to {}{}", step_of(span.first), step_of(span.last), time);
}

ConsistencyVerdict judge_nees(std::span<const Moments> per_step, std::span<const double> total_dof_per_step,
                              double confidence, const RunAverages* runs) {
  const bool of_runs = runs != nullptr && runs->moments.count >= kFewestRunsCompared;
  return judge_sums(per_step, total_dof_per_step, confidence,
                    {.step = chi_square_step,
                     .overall = any_correlation,
                     .method = of_runs ? "every step (Bonferroni) and the averages of whole runs, which are "
                                         "independent whatever the correlation in time"
                                       : "every step (Bonferroni) and the sum over steps (expected-shortfall "
                                         "bound), both valid for any correlation in time",
                     .runs = of_runs ? runs : nullptr});
}

ConsistencyVerdict judge_nis(std::span<const Moments> per_step, std::span<const double> total_dof_per_step,
                             double confidence, double tau) {
  const auto overall = [tau](const std::vector<StepTest>& tested) {
    return times(tau, chi_square_law(total_dof_of(tested) / tau));
  };
  return judge_sums(
      per_step, total_dof_per_step, confidence,
      {.step = chi_square_step,
       .overall = overall,
       .method = "every step (Bonferroni) and the chi-square sum over runs and " + steps_text(tau)});
}

ConsistencyVerdict judge_gated_nis(std::span<const Moments> per_step, double dof, double gate,
                                   double confidence, double tau) {
  const Cumulants one = truncated_chi_square_cumulants(dof, gate);
  std::vector<double> total_dofs;
  for (const Moments& step : per_step) total_dofs.push_back(dof * static_cast<double>(step.count));
  const auto sum_of = [one](double count) { return cumulant_law(one * count); };
  return judge_sums(
      per_step, total_dofs, confidence,
      {.step = [&](double /*total_dof*/, double count) { return sum_of(count); },
       .overall =
           [&](const std::vector<StepTest>& tested) {
             return times(tau, sum_of(total_count_of(tested) / tau));
           },
       .method = fmt::format("every step (Bonferroni) and the sum over runs and {}, both by the "
                             "truncated chi-square law of a gated innovation",
                             steps_text(tau))});
}

}  // namespace credence::internal
