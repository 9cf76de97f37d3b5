#include "analysis/evidence/consistency_gated.h"

#include <vector>

#include "analysis/evidence/consistency_judge.h"
#include "analysis/laws/chi_square_truncated.h"

namespace credence::internal {

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
