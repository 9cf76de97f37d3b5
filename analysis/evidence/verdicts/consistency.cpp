#include "analysis/evidence/verdicts/consistency.h"

#include <fmt/format.h>

#include <vector>

#include "analysis/evidence/verdicts/consistency_judge.h"
#include "analysis/laws/chi_square/chi_square_truncated.h"
#include "analysis/laws/mean/run_mean.h"

namespace credence::internal {
namespace {

SumLaw chi_square_step(double total_dof, double /*count*/) { return chi_square_law(total_dof); }

SumLaw any_correlation(const std::vector<StepTest>& tested) {
  std::vector<double> dofs;
  dofs.reserve(tested.size());
  for (const StepTest& step : tested) dofs.push_back(step.total_dof);
  return dependent_law(dofs);
}

SumLaw white_steps(const std::vector<StepTest>& tested) {
  double dof = 0.0;
  for (const StepTest& step : tested) dof += step.total_dof;
  return chi_square_law(dof);
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
                             double confidence) {
  return judge_sums(per_step, total_dof_per_step, confidence,
                    {.step = chi_square_step,
                     .overall = white_steps,
                     .method = "every step (Bonferroni) and the chi-square sum over runs and white steps"});
}

ConsistencyVerdict judge_gated_nis(std::span<const Moments> per_step, double dof, double gate,
                                   double confidence) {
  const Cumulants one = truncated_chi_square_cumulants(dof, gate);
  std::vector<double> total_dofs;
  for (const Moments& step : per_step) total_dofs.push_back(dof * static_cast<double>(step.count));
  const auto sum_of = [one](double count) { return cumulant_law(one * count); };
  return judge_sums(per_step, total_dofs, confidence,
                    {.step = [&](double /*total_dof*/, double count) { return sum_of(count); },
                     .overall =
                         [&](const std::vector<StepTest>& tested) {
                           double count = 0.0;
                           for (const StepTest& step : tested) count += static_cast<double>(step.count);
                           return sum_of(count);
                         },
                     .method = "every step (Bonferroni) and the sum over runs and white steps, "
                               "both by the truncated chi-square law of a gated innovation"});
}

}  // namespace credence::internal
