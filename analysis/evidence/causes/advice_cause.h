#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/evidence/causes/cause_findings.h"

namespace credence::internal {

/// What a wrong filter most likely has wrong.
enum class Cause {
  lost_runs,               ///< a few runs are wrong, and the others are not
  shared_noise,            ///< runs of the same noise, or with an error that is the same in all of them
  unwrapped_angle,         ///< an innovation of an angle beyond half a turn
  wide_angle,              ///< an angle so uncertain that its wrapped error is not Gaussian
  outliers,                ///< a few innovations or errors beyond any law: a wrong match
  gated_innovations,       ///< NIS is cut off at a gate
  innovation_unit,         ///< a component of the innovations is in another unit than S
  innovation_correlation,  ///< two components of the innovations are correlated otherwise than in S
  late_measurements,       ///< the estimate lags behind the truth by a time
  truth_behind,            ///< the truth is that of an earlier time
  bias,                    ///< the innovations have a mean, or the errors
  one_step,                ///< all is right until one step, is wrong there, and fades
  initial_covariance,      ///< only the first steps are inconsistent
  initial_covariance_or_process_noise,    ///< errors before the first innovation are, and cannot tell which
  initial_covariance_or_nonlinear_start,  ///< one of them; the innovations cannot tell which
  nonlinear_start,  ///< only they are, but for the very first: P0 is right, the linearisation there is not
  process_noise_too_small,
  process_noise_too_large,
  measurement_noise_too_small,
  measurement_noise_too_large,
  process_or_measurement_noise,  ///< one of them; the innovations cannot tell which
  coloured_noise,                ///< innovations of the right size but not white
  cross_covariance,  ///< where P has none errors are correlated, or no block is inconsistent and the whole is
  sequential_sensors,               ///< innovations of several sensors, all taken against one prior
  heavy_tails,                      ///< the covariance is right, the law is not Gaussian
  wrong_dof,                        ///< the spread of NEES is that of another number of dof
  linearisation,                    ///< a nonlinear filter gains information that is not there
  linearisation_or_bias,            ///< a single run, in which a bias cannot be told from an error that stays
  process_noise_or_linearisation,   ///< steps without an innovation make the errors too large for P
  claimed_sigma,                    ///< P is too small in some rows and too large in others, by its σ
  covariance_scale,                 ///< P is wrong by a factor, and nothing tells why
  covariance_at_steps,              ///< single steps alone are wrong, and the mean over all is not
  measurement_noise_of_components,  ///< R is too small in a component of a sensor and too large in another
  truth,                            ///< what the errors are taken against is wrong, and not the filter
  inflation,                        ///< the filter inflates its covariance on purpose
};

/// The cause in words.
std::string_view to_string(Cause cause);

/// `optimistic` or `pessimistic` where it makes a filter nothing else; else `undecided`.
Verdict side_of(Cause cause);

/// A cause with its reason, the numbers included.
struct CauseFound {
  Cause cause = Cause::covariance_scale;
  std::string why;
};

/// The causes that the findings point to, the most specific first, by the rules of cause_rules.h in their
/// order; empty for a consistent filter but for chance. A hint: signatures that are tests of their own are at
/// the level (1 − confidence)/17 each, and most are looked at where the word rejects alone. How often a right
/// filter has a cause at all is measured: statistics, "Which cause".
std::vector<CauseFound> find_causes(const Findings& findings);

}  // namespace credence::internal
