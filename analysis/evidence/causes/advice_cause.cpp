#include "analysis/evidence/causes/advice_cause.h"

#include "analysis/evidence/causes/cause_rules.h"
#include "analysis/evidence/causes/cause_signature.h"

namespace credence::internal {
namespace {

struct CauseRule {
  Causes (*find)(const Findings&);
  /// Whether it is asked only where no rule before it has named a cause.
  bool alone;
};

// In the order in which they are asked: what no covariance mends, what stands beside other causes, then what
// each takes for granted that those before it were not.
constexpr CauseRule kRules[] = {
    {find_unwrapped_angle, false},
    {find_rejected_innovations, false},
    {find_runs_that_are_lost, true},
    {find_shared_noise, true},
    {find_wide_angle, false},
    {find_outliers, false},
    {find_wrong_step, true},
    {find_heavy_tails, true},
    {find_gate, false},
    {find_sequential_sensors, false},
    {find_late_measurements, false},
    {find_bias, true},
    {find_inflation, false},
    {find_dropped_cross_covariance, true},
    {find_opposed_components, true},
    {find_wrong_component, true},
    {find_wrong_pair, true},
    {find_wrong_before_innovations, true},
    {find_wrong_first_innovation, true},
    {find_coloured_noise, true},
    {find_wrong_first_stretch, true},
    {find_wrong_first_step, true},
    {find_start_that_dies_out, true},
    {find_start_beside_the_rest, true},
    {find_wrong_sensor, true},
    {find_wrong_noise, true},
    {find_wrong_single_steps, true},
    {find_error_of_truth, true},
    {find_linearisation, true},
    {find_wrong_by_claimed_sigma, true},
    {find_constant_offset, true},
    {find_wrong_dof, true},
    {find_noise_by_errors, true},
    {find_joint_inconsistency, true},
    {find_noise_by_growth, true},
    {find_wrong_gain, true},
    {find_scale, true},
    {find_rejection_beside, false},
    {find_perhaps_gate, false},
};

/// Whether it is a start, a noise, a linearisation, a scale or a dof, as is named where nothing else is
/// found.
bool takes_the_rest_for_granted(Cause cause) {
  switch (cause) {
    case Cause::initial_covariance:
    case Cause::initial_covariance_or_process_noise:
    case Cause::initial_covariance_or_nonlinear_start:
    case Cause::nonlinear_start:
    case Cause::process_noise_too_small:
    case Cause::process_noise_too_large:
    case Cause::measurement_noise_too_small:
    case Cause::measurement_noise_too_large:
    case Cause::process_or_measurement_noise:
    case Cause::linearisation:
    case Cause::linearisation_or_bias:
    case Cause::process_noise_or_linearisation:
    case Cause::wrong_dof:
    case Cause::covariance_scale:
    case Cause::covariance_at_steps: return true;
    default: return false;
  }
}

/// Whether innovations tell it, in all runs: then a run that is lost does not hide it.
bool told_by_innovations(Cause cause) {
  switch (cause) {
    case Cause::gated_innovations:
    case Cause::innovation_unit:
    case Cause::innovation_correlation:
    case Cause::process_noise_too_small:
    case Cause::process_noise_too_large:
    case Cause::measurement_noise_too_small:
    case Cause::measurement_noise_too_large:
    case Cause::measurement_noise_of_components:
    case Cause::process_or_measurement_noise:
    case Cause::coloured_noise: return true;
    default: return false;
  }
}

/// Beside lost runs, where innovations are too small: no run that is lost makes them so.
bool wrong_beside_lost_runs(const Findings& findings) {
  const Verdict nis = findings.nis.verdict;
  return !findings.lost.runs.empty() && (nis == Verdict::pessimistic || nis == Verdict::mixed);
}

}  // namespace

std::string_view to_string(Cause cause) {
  switch (cause) {
    case Cause::lost_runs: return "a filter that loses its way in a few runs";
    case Cause::shared_noise:
      return "runs that are not independent, as several over one data set, or an error that all of them "
             "share";
    case Cause::unwrapped_angle: return "an angle that is not wrapped";
    case Cause::wide_angle: return "an angle too uncertain for a Gaussian law";
    case Cause::outliers: return "outliers, such as wrong associations";
    case Cause::gated_innovations: return "innovations that had to pass a gate";
    case Cause::innovation_unit: return "a component of the innovations in another unit than its S";
    case Cause::innovation_correlation:
      return "a covariance between components of a measurement, which R lacks, or has and should not";
    case Cause::late_measurements: return "measurements that arrive late, or a truth that is ahead";
    case Cause::truth_behind: return "a truth that is behind in time, or estimates of a later time";
    case Cause::bias: return "a bias of the sensor or of the model";
    case Cause::one_step:
      return "what happens at one step, as a jump, an outlier, a P set anew, or a measurement far from "
             "linear";
    case Cause::initial_covariance: return "the initial covariance";
    case Cause::initial_covariance_or_process_noise:
      return "the initial covariance or process noise; the errors before the first innovation cannot tell "
             "which";
    case Cause::initial_covariance_or_nonlinear_start:
      return "the initial covariance, or the linearisation at so uncertain a start";
    case Cause::nonlinear_start: return "the linearisation at so uncertain a start";
    case Cause::process_noise_too_small: return "process noise Q assumed too small";
    case Cause::process_noise_too_large: return "process noise Q assumed too large";
    case Cause::measurement_noise_too_small: return "measurement noise R assumed too small";
    case Cause::measurement_noise_too_large: return "measurement noise R assumed too large";
    case Cause::measurement_noise_of_components:
      return "measurement noise R assumed too small in some components and too large in others";
    case Cause::process_or_measurement_noise:
      return "process or measurement noise; the innovations cannot tell which";
    case Cause::coloured_noise: return "noise that is correlated in time";
    case Cause::cross_covariance: return "cross-covariances between the blocks";
    case Cause::sequential_sensors:
      return "innovations of several sensors that were all computed from the same prior, or noise that these "
             "share";
    case Cause::truth: return "an error of the truth: its noise, its time or its place";
    case Cause::heavy_tails: return "errors that are not Gaussian, with heavy tails; the covariance is right";
    case Cause::wrong_dof: return "a wrong number of degrees of freedom";
    case Cause::linearisation:
      return "the filter's linearisation at its own estimates, which can make unobservable directions look "
             "observable";
    case Cause::linearisation_or_bias:
      return "the filter's linearisation at its own estimates, or a bias, of a sensor, a lever arm or the "
             "model; one run cannot tell which";
    case Cause::process_noise_or_linearisation:
      return "process noise Q assumed too small, or the linearisation of the motion";
    case Cause::claimed_sigma:
      return "the covariance where its σ is small, or where it is large: it is right on average alone";
    case Cause::covariance_scale: return "the scale of the covariance";
    case Cause::covariance_at_steps: return "the covariance at single steps";
    case Cause::inflation: return "the deliberate inflation of the covariance";
  }
  return "unknown";
}

Verdict side_of(Cause cause) {
  switch (cause) {
    case Cause::lost_runs:
    case Cause::unwrapped_angle:
    case Cause::outliers:
    case Cause::late_measurements:
    case Cause::truth_behind:
    case Cause::bias:
    case Cause::one_step:
    case Cause::nonlinear_start:
    case Cause::process_noise_too_small:
    case Cause::measurement_noise_too_small:
    case Cause::linearisation:
    case Cause::linearisation_or_bias:
    case Cause::process_noise_or_linearisation:
    case Cause::truth: return Verdict::optimistic;
    case Cause::process_noise_too_large:
    case Cause::measurement_noise_too_large:
    case Cause::inflation: return Verdict::pessimistic;
    default: return Verdict::undecided;
  }
}

std::vector<CauseFound> find_causes(const Findings& findings) {
  std::vector<CauseFound> found;
  const bool beside_lost = wrong_beside_lost_runs(findings);
  for (const auto& [find, alone] : kRules) {
    const bool only_lost = beside_lost && found.size() == 1 && found.front().cause == Cause::lost_runs;
    if (alone && !found.empty() && !only_lost) continue;
    Causes more = find(findings);
    if (alone && only_lost)
      std::erase_if(more, [](const CauseFound& c) { return !told_by_innovations(c.cause); });
    found.insert(found.end(), more.begin(), more.end());
  }
  if (!found.empty() && takes_the_rest_for_granted(found.front().cause))
    found.front().why += short_delay(findings) + untested_causes(findings);
  return found;
}

}  // namespace credence::internal
