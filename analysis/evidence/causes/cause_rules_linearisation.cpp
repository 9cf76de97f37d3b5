#include <fmt/format.h>

#include <cmath>

#include "analysis/evidence/causes/cause_rules.h"
#include "analysis/evidence/causes/cause_signature.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

// Consistent, or so nearly that the errors are wrong by more than ten times as much.
bool innovations_fit(const Findings& findings) {
  if (findings.nis.verdict == Verdict::consistent) return true;
  if (findings.nis.verdict == Verdict::undecided) return false;
  return std::abs(excess_of(findings.nis)) < kSmallBesideErrors * excess_of(findings.nees);
}

}  // namespace

Causes find_linearisation(const Findings& findings) {
  if (!findings.nonlinear || findings.nees.verdict != Verdict::optimistic) return {};
  if (!innovations_fit(findings)) return {};
  if (findings.whiteness && !findings.whiteness->reason.empty())
    return {};  // nor is their size all that tells
  const bool moved = findings.nis.verdict == Verdict::optimistic;
  const std::string why = fmt::format(
      "mean NEES is {} of {} while {} (mean NIS {} of {}){}", number_text(findings.nees.mean, 3),
      number_text(findings.nees.expected, 3),
      findings.nis.verdict == Verdict::consistent
          ? "the innovations are as they should be"
          : fmt::format("NIS is {} times the expected one", number_text(1.0 + excess_of(findings.nis), 3)),
      number_text(findings.nis.mean), number_text(findings.nis.expected), untested_correlation(findings));
  // With P too small (Σ ⪰ P) and the right F and Q NEES cannot grow in P⁻ = F P Fᵀ + Q, as tr (P⁻)⁻¹ F (Σ −
  // P) Fᵀ ≤ tr P⁻¹ (Σ − P), nor in the others with the right H and R.
  if (grows(findings.growth_without_innovations, findings) &&
      !grows(findings.growth_with_innovations, findings)) {
    return {{Cause::process_noise_or_linearisation,
             fmt::format("{}, and NEES over its dof grows by {} over the steps without an "
                         "innovation, by {} over those with one",
                         why, number_text(findings.growth_without_innovations.mean, 3),
                         number_text(findings.growth_with_innovations.mean, 3))}};
  }
  if (lags_tell_process_noise(findings)) {
    return {{Cause::process_noise_or_linearisation,
             why + ", and the innovations are correlated as those of a gain that is too small"}};
  }
  // A mean of the errors, which a bias makes, shows in many runs.
  constexpr std::int64_t kMany = 20;
  const bool few = findings.error_mean_runs > 0 && findings.error_mean_runs < kMany;
  return {{moved ? Cause::process_noise_or_linearisation
           : few ? Cause::linearisation_or_bias
                 : Cause::linearisation,
           why}};
}

}  // namespace credence::internal
