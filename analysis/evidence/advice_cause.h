#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/evidence/advice.h"
#include "analysis/evidence/consistency.h"
#include "analysis/laws/block_correlation.h"
#include "analysis/laws/coverage.h"
#include "analysis/laws/error_correlation.h"
#include "analysis/laws/goodness_of_fit.h"
#include "analysis/laws/lateness.h"
#include "analysis/laws/whiteness.h"
#include "analysis/laws/zero_mean.h"

namespace credence::internal {

/// What a wrong filter most likely has wrong.
enum class Cause {
  unwrapped_angle,                      ///< an innovation of an angle beyond half a turn
  wide_angle,                           ///< an angle so uncertain that its wrapped error is not Gaussian
  outliers,                             ///< a few innovations or errors beyond any law: a wrong match
  gated_innovations,                    ///< NIS is cut off at a gate
  late_measurements,                    ///< the estimate lags behind the truth by a time
  bias,                                 ///< the innovations have a mean, or the errors
  initial_covariance,                   ///< only the first steps are inconsistent
  initial_covariance_or_process_noise,  ///< errors before the first innovation are, and cannot tell which
  nonlinear_start,  ///< only they are, but for the very first: P0 is right, the linearisation there is not
  process_noise_too_small,
  process_noise_too_large,
  measurement_noise_too_small,
  measurement_noise_too_large,
  process_or_measurement_noise,  ///< one of them; the innovations cannot tell which
  coloured_noise,                ///< innovations of the right size but not white
  cross_covariance,  ///< where P has none errors are correlated, or no block is inconsistent and the whole is
  sequential_sensors,              ///< innovations of several sensors, all taken against one prior
  heavy_tails,                     ///< the covariance is right, the law is not Gaussian
  wrong_dof,                       ///< the spread of NEES is that of another number of dof
  linearisation,                   ///< a nonlinear filter gains information that is not there
  process_noise_or_linearisation,  ///< steps without an innovation make the errors too large for P
  covariance_scale,                ///< P is wrong by a factor, and nothing tells why
  inflation,                       ///< the filter inflates its covariance on purpose
};

/// The cause in words.
std::string_view to_string(Cause cause);

/// A gate that the innovations had to pass: none lies beyond, and those within follow the law cut off there.
struct GateFound {
  double nis = 0.0;       ///< the largest there is
  double expected = 0.0;  ///< values beyond it without a gate
  double p_value = 0.0;   ///< of χ² cut off there (Anderson-Darling): it fits
};

/// What the tests found; what was not tested stays empty.
struct Findings {
  ConsistencyVerdict nees, nis;
  /// Best of the innovations after the first fifth of the steps, so that a wrong start does not colour them.
  std::optional<WhitenessTest> whiteness = {};
  bool not_white = false;  ///< the portmanteau of all lags speaks against whiteness
  /// Of the innovations averaged over each run, so that it holds for innovations that are not white too.
  std::optional<ZeroMeanTest> innovation_mean = {};
  struct ErrorMean {
    ZeroMeanTest test;  ///< of the errors over their σ, averaged over each run
    std::string state;  ///< with the largest
  };
  std::optional<ErrorMean> error_mean = {};
  std::optional<LatenessTest> lateness = {};
  std::optional<GoodnessOfFit> fit = {};  ///< NIS against the plain law
  std::optional<GateFound> gate = {};
  /// How many NIS (or NEES) values lie within the quantile `far_tail_probability` of their law.
  std::optional<CoverageCount> far_tail = {};
  double far_tail_probability = 0.9999;
  /// Gross outliers (kGrossOutlier) among the innovations, and where they are in time.
  struct GrossOutliers {
    std::int64_t all = 0, early = 0;  ///< of these in the first fifth of the steps
    double early_share = 0.0;         ///< of all innovations in that fifth
    CoverageCount late = {};          ///< innovations of the second half: those that are none
    bool rest_fits = false;           ///< the verdict on NIS without them is `consistent`
  };
  GrossOutliers gross_outliers = {};
  std::optional<ResponsibleBlock> block = {};
  /// Of errors that P claims to be uncorrelated, over all steps of the runs.
  std::optional<ErrorCorrelationTest> error_correlation = {};
  std::int64_t unwrapped_innovations = 0;  ///< of an angle, outside [−π, π]: impossible once wrapped
  CoverageCount narrow_angles = {};        ///< angles of the state whose σ is no wider than kWideAngle
  Moments nees_values = {};                ///< single NEES values over runs and steps
  Moments nees_before_innovations = {};    ///< over runs, at the step before any innovation; else empty
  /// Of each run, what NEES over its dof gains over the steps without an innovation (before the first one of
  /// all), and over the others; empty where not every step of every run is known.
  Moments growth_without_innovations = {}, growth_before_innovations = {}, growth_with_innovations = {};
  std::optional<double> measurement_noise_share = {};  ///< mean of tr(S⁻¹ R) / m
  bool nonlinear = false;                              ///< the filter linearises at its own estimates
  bool inflated = false;                               ///< it is known to inflate its covariance
  struct SensorPair {
    std::string first, second;
    BlockCorrelationTest correlation;
  };
  std::vector<SensorPair> sensor_pairs = {};      ///< that are correlated at one step
  std::optional<double> heavy_tail_p_value = {};  ///< only where nothing speaks against the second moments
};

/// A cause with its reason, the numbers included.
struct CauseFound {
  Cause cause = Cause::covariance_scale;
  std::string why;
};

/// The causes that the findings point to, the most specific first; empty for a consistent filter but for
/// chance.
///
/// Rules, each a signature (statistics, "Which cause"): an angle innovation beyond half a
/// turn; an angle of the state wider than kWideAngle; outliers beyond the far tail; heavy tails with the
/// right second moments; a law cut off at a gate; two sensors correlated at one step more than each is with
/// itself in time; errors that are the way of some steps; a mean of the innovations, or of the errors, and
/// beside it the noise, judged by the innovations less their mean; errors that are correlated where P claims
/// that they are not; NEES of the steps before the first innovation, which P0 and Q alone make, and the first
/// innovation where that fits; a first NEES or NIS that is wrong, as P0 makes it, while NIS is right later;
/// an inconsistency of the first fifth of the steps that is all but gone in the second half; innovations more
/// correlated than a wrong gain makes them; the sign of the lags with that of the NIS, or else of NEES (gain
/// too small: positive, too large: negative), or, for an S that is nearly R, innovations whiter than a wrong
/// Q would leave them; Var(NEES) = 2 mean, as for another dof, against 2 mean²/n of a wrong factor; a joint
/// inconsistency that no block shares. Heuristic: a hint; signatures that are tests of their own need
/// (1 − confidence) / 15.
std::vector<CauseFound> find_causes(const Findings& findings);

}  // namespace credence::internal
