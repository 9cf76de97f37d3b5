#include "analysis/advice_cause.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace credence {
namespace {

double alpha_of(const Findings& findings) {
  return 1.0 - (findings.nis.confidence > 0.0 ? findings.nis.confidence : findings.nees.confidence);
}

void find_outliers(const Findings& findings, std::vector<CauseFound>& found) {
  if (!findings.far_tail || findings.far_tail->total == 0) return;
  const CoverageCount& tail = *findings.far_tail;
  const double outside = static_cast<double>(tail.total - tail.inside);
  const double expected = (1.0 - findings.far_tail_probability) * static_cast<double>(tail.total);
  const double p = binomial_p_value(tail, findings.far_tail_probability);
  // A wrong scale fills the tail too, but gradually: outliers are far too many for the mean that goes with
  // them.
  const bool many = outside > 10.0 * std::max(1.0, expected);
  const bool body_fits = !findings.fit || findings.fit->kolmogorov < 0.05;
  if (p <= alpha_of(findings) && many && body_fits) {
    found.push_back(
        {Cause::outliers, fmt::format("{} of {} values lie beyond the {:.4g} quantile, {:.2g} expected",
                                      outside, tail.total, findings.far_tail_probability, expected)});
  }
}

void find_gate(const Findings& findings, std::vector<CauseFound>& found) {
  if (!findings.fit || !findings.gated_fit) return;
  const double alpha = alpha_of(findings);
  if (findings.fit->anderson_p_value <= alpha && findings.gated_fit->anderson_p_value > alpha) {
    found.push_back(
        {Cause::gated_innovations,
         fmt::format("NIS fits its law only when that is cut off at the gate (p = {:.2g}, without {:.2g})",
                     findings.gated_fit->anderson_p_value, findings.fit->anderson_p_value)});
  }
}

void find_bias(const Findings& findings, std::vector<CauseFound>& found) {
  if (!findings.innovation_mean || !(findings.innovation_mean->p_value <= alpha_of(findings))) return;
  found.push_back(
      {Cause::biased_innovation,
       fmt::format("the innovation has mean {:.2g} standard deviations (p = {:.2g})",
                   findings.innovation_mean->mean.cwiseAbs().maxCoeff(), findings.innovation_mean->p_value)});
}

// Whether a verdict fails, and only because of steps among the first tenth.
bool only_first_steps(const ConsistencyVerdict& verdict) {
  if (!is_inconsistent(verdict.verdict) || verdict.steps_rejected == 0) return false;
  const std::size_t first = std::max<std::size_t>(3, verdict.steps.size() / 10);
  if (verdict.steps.size() < 2 * first) return false;
  const auto outside = [](const StepTest& step) {
    return step.mean < step.simultaneous_lower || step.mean > step.simultaneous_upper;
  };
  const auto boundary = verdict.steps.begin() + static_cast<std::ptrdiff_t>(first);
  return std::any_of(verdict.steps.begin(), boundary, outside) &&
         std::none_of(boundary, verdict.steps.end(), outside);
}

void find_initial_covariance(const Findings& findings, std::vector<CauseFound>& found) {
  const bool nees = only_first_steps(findings.nees);
  const bool nis = only_first_steps(findings.nis);
  if (!nees && !nis) return;
  if (is_inconsistent(findings.nees.verdict) && !nees) return;
  if (is_inconsistent(findings.nis.verdict) && !nis) return;
  const ConsistencyVerdict& verdict = nees ? findings.nees : findings.nis;
  found.push_back({Cause::initial_covariance, fmt::format("only the first steps are {}, the worst is step {}",
                                                          to_string(verdict.verdict), verdict.worst_step)});
}

// The gain is too small if innovations are followed by others of the same sign, too large if of the opposite.
void find_noise(const Findings& findings, std::vector<CauseFound>& found) {
  if (!findings.whiteness || !(findings.whiteness->p_value <= alpha_of(findings))) return;
  const double lag_1 = findings.whiteness->autocorrelation.at(0);
  if (std::abs(lag_1) <= findings.whiteness->band.at(0)) return;
  const Verdict nis = findings.nis.verdict;
  if (!is_inconsistent(nis)) {
    found.push_back({Cause::coloured_noise,
                     fmt::format("NIS has the right size but its lag-1 autocorrelation is {:.2g}", lag_1)});
    return;
  }
  const bool high = nis == Verdict::optimistic;
  const Cause cause =
      high ? (lag_1 > 0.0 ? Cause::process_noise_too_small : Cause::measurement_noise_too_small)
           : (lag_1 > 0.0 ? Cause::measurement_noise_too_large : Cause::process_noise_too_large);
  found.push_back({cause, fmt::format("mean NIS {:.3g} of {:.3g} with a lag-1 autocorrelation of {:.2g}",
                                      findings.nis.mean, findings.nis.expected, lag_1)});
}

void find_cross_covariance(const Findings& findings, std::vector<CauseFound>& found) {
  if (!findings.block || !findings.block->joint_only) return;
  found.push_back({Cause::cross_covariance,
                   fmt::format("every block is consistent but the whole state has mean NEES {:.3g} of {:.3g}",
                               findings.nees.mean, findings.nees.expected)});
}

// For c χ²(n) the variance is 2 mean²/n, for χ²(n') it is 2 mean.
void find_dof_or_scale(const Findings& findings, std::vector<CauseFound>& found) {
  if (!is_inconsistent(findings.nees.verdict)) return;
  const Moments& values = findings.nees_values;
  if (values.count >= 100 && values.mean > 0.0 && values.m2 > 0.0) {
    const double ratio = values.variance() / (2.0 * values.mean);
    const double as_scale = values.mean / findings.nees.expected;
    const double midway = std::sqrt(as_scale);
    if (as_scale > 1.0 ? ratio < midway : ratio > midway) {
      found.push_back(
          {Cause::wrong_dof,
           fmt::format("NEES has mean {:.3g} and variance {:.3g}, as with {:.3g} degrees of freedom "
                       "instead of {:.3g}",
                       values.mean, values.variance(), values.mean, findings.nees.expected)});
      return;
    }
  }
  if (!found.empty()) return;
  found.push_back({Cause::covariance_scale,
                   fmt::format("mean NEES {:.3g} of {:.3g}", findings.nees.mean, findings.nees.expected)});
}

}  // namespace

std::string_view to_string(Cause cause) {
  switch (cause) {
    case Cause::outliers:
      return "outliers: an angle that is not wrapped, or a wrong association";
    case Cause::gated_innovations:
      return "innovations that had to pass a gate";
    case Cause::biased_innovation:
      return "a bias of the sensor or of the model";
    case Cause::initial_covariance:
      return "the initial covariance";
    case Cause::process_noise_too_small:
      return "process noise Q assumed too small";
    case Cause::process_noise_too_large:
      return "process noise Q assumed too large";
    case Cause::measurement_noise_too_small:
      return "measurement noise R assumed too small";
    case Cause::measurement_noise_too_large:
      return "measurement noise R assumed too large";
    case Cause::coloured_noise:
      return "noise that is correlated in time";
    case Cause::cross_covariance:
      return "cross-covariances between the blocks";
    case Cause::wrong_dof:
      return "a wrong number of degrees of freedom";
    case Cause::covariance_scale:
      return "the scale of the covariance";
  }
  return "unknown";
}

std::vector<CauseFound> find_causes(const Findings& findings) {
  std::vector<CauseFound> found;
  find_outliers(findings, found);
  find_gate(findings, found);
  find_bias(findings, found);
  find_initial_covariance(findings, found);
  if (found.empty()) find_noise(findings, found);
  find_cross_covariance(findings, found);
  find_dof_or_scale(findings, found);
  return found;
}

}  // namespace credence
