#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evidence/causes/advice.h"
#include "analysis/evidence/causes/lost_runs.h"
#include "analysis/evidence/verdicts/claimed_sigma.h"
#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/correlation/block_correlation.h"
#include "analysis/laws/correlation/error_correlation.h"
#include "analysis/laws/correlation/lateness.h"
#include "analysis/laws/correlation/whiteness.h"
#include "analysis/laws/gate_rejection.h"
#include "analysis/laws/mean/mean_at_steps.h"
#include "analysis/laws/mean/zero_mean.h"
#include "analysis/laws/shape/component_variances.h"
#include "analysis/laws/shape/coverage.h"
#include "analysis/laws/shape/goodness_of_fit.h"

namespace credence::internal {

struct Evidence;
struct Judgement;

/// A gate that the innovations had to pass: none lies beyond, and those within follow the law cut off there
/// unless it was known before.
struct GateFound {
  double nis = 0.0;       ///< the largest there is
  double expected = 0.0;  ///< values beyond it without a gate
  double p_value = 0.0;   ///< of χ² cut off there (Anderson-Darling): it fits
  /// Log-likelihood of χ² cut off there over that of the χ² scaled to their mean, as of an S that is wrong by
  /// a factor.
  double over_scaled = 0.0;
  bool known = false;  ///< to whoever made the evidence: it need not fit, and is no cause

  /// That many missing values are no chance, of probability 3e-4, and no S that is too large explains them as
  /// well.
  bool is_certain() const {
    constexpr double kFewest = 8.0, kLikelier = 2.0;
    return known || (expected >= kFewest && over_scaled >= kLikelier);
  }
};

/// What the tests found; what was not tested stays empty.
struct Findings {
  ConsistencyVerdict nees, nis;
  /// Best of the innovations after the first fifth of the steps, so that a wrong start does not colour them.
  std::optional<WhitenessTest> whiteness = {};
  /// Of one sensor: mean NIS over its dof.
  std::optional<double> whiteness_nis = {};  ///< of that of `whiteness`
  /// Of several sensors those whose own NIS is wrong, the most wrong first.
  struct WrongSensor {
    std::string name;
    double nis = 0.0;  ///< mean over its dof
    WhitenessTest whiteness;
    double noise_share = kNaN;  ///< tr(S⁻¹ R)/m
  };
  std::vector<WrongSensor> wrong_sensors = {};
  /// A component of the innovations of a sensor that is wrong otherwise than the others of it.
  struct WrongComponent {
    std::string name, sensor;
    ComponentVariance factor;
    double others = 0.0;        ///< the factor of the others that is nearest to it
    double noise_share = kNaN;  ///< tr(S⁻¹ R)/m of the sensor
    double nis = kNaN;          ///< mean NIS over its dof of the sensor
    double mean_factor = kNaN;  ///< of all its components
  };
  std::optional<WrongComponent> wrong_component = {};  ///< the most wrong one of all sensors
  /// Components of the innovations of a sensor that are larger and smaller than S says, as no noise makes
  /// them that is wrong in one direction.
  struct OpposedComponents {
    std::string large_name, small_name;
    ComponentVariance large, small;  ///< the largest and the smallest factor
    /// Lag 1 of the large less that of the small one, in standard errors: below zero R, above it Q makes them
    /// so; 0: not known.
    double lags = 0.0;
    double noise_share = kNaN;  ///< as of a component
  };
  std::optional<OpposedComponents> opposed_components = {};  ///< of the sensor that has them farthest apart
  /// Two components of the innovations of a sensor that are each as large as S says, and their sum and
  /// difference, each over its σ, are not.
  struct WrongPair {
    std::string sum_name, difference_name;
    ComponentVariance sum, difference;
    double noise_share = kNaN;  ///< as of a component
  };
  std::optional<WrongPair> wrong_pair = {};  ///< the most wrong one of all sensors
  bool not_white = false;                    ///< the portmanteau of all lags speaks against whiteness
  /// Of the innovations averaged over each run, so that it holds for innovations that are not white too.
  std::optional<ZeroMeanTest> innovation_mean = {};
  std::optional<ZeroMeanTest> first_innovation = {};  ///< of that of a sensor; Bonferroni over the sensors
  struct ErrorMean {
    ZeroMeanTest test;  ///< of the errors over their σ, averaged over each run
    std::string state;  ///< with the largest
  };
  std::optional<ErrorMean> error_mean = {};
  std::int64_t error_mean_runs = 0;  ///< whose errors' mean was looked at; 0: none
  MeanAtSteps mean_at_steps = {};    ///< of the errors of a whole state of at most 24
  std::optional<LatenessTest> lateness = {};
  std::optional<GoodnessOfFit> fit = {};  ///< NIS against the plain law, of the sensor of `far_tail`
  std::optional<GateFound> gate = {};
  std::optional<GateFound> perhaps_gate = {};  ///< of a sensor whose NIS are too small
  struct CutOff {
    double nis = 0.0;  ///< the largest there is
    double expected =
        0.0;  ///< values beyond it by the law of this mean, which a covariance wrong by a factor has
  };
  std::optional<CutOff> cut_off =
      {};  ///< where these are too many to be missing by chance, and no gate was found
  std::optional<GateRejection> rejection = {};  ///< by a gate beyond which innovations are logged
  /// How many NIS (or NEES) values lie within the quantile `far_tail_probability` of their law: of the sensor
  /// with the largest share beyond.
  std::optional<CoverageCount> far_tail = {};
  struct SizeOfNis {
    double mean = 0.0, expected = 0.0;
  };
  std::optional<SizeOfNis> far_tail_nis = {};  ///< of that sensor
  double far_tail_probability = 0.9999;
  /// Gross outliers (kGrossOutlier) among the innovations, and where they are in time.
  struct GrossOutliers {
    std::int64_t all = 0, early = 0;          ///< of these in the first fifth of the steps
    std::vector<std::int64_t> at_steps = {};  ///< of each step
    double early_share = 0.0;                 ///< of all innovations in that fifth
    CoverageCount late = {};                  ///< innovations of the second half: those that are none
    bool rest_fits = false;                   ///< the verdict on NIS without them is `consistent`
  };
  GrossOutliers gross_outliers = {};
  std::optional<ResponsibleBlock> block = {};
  bool any_block_is_wrong = false;  ///< by its own NEES
  ClaimedSigmaTest claimed_sigma = {};
  LostRuns lost = {};  ///< runs that alone are wrong
  /// Of errors that P claims to be uncorrelated, over all steps of the runs.
  std::optional<ErrorCorrelationTest> error_correlation = {};
  std::int64_t unwrapped_innovations = 0;  ///< of an angle, outside [−π, π]: impossible once wrapped
  std::string unmarked_angles = {};        ///< which numbers are a turn off (whole_turns.h); empty: none
  CoverageCount narrow_angles = {};        ///< angles of the state whose σ is no wider than kWideAngle
  Moments nees_values = {};                ///< single NEES values over runs and steps
  double white_share = 0.0;  ///< of the variance of NEES, what one row does not share with the next
  Moments nees_before_innovations = {};  ///< over runs, at the step before any innovation; else empty
  SkewedMoments nees_of_runs_before_innovations = {};  ///< the mean of NEES over its dof of each run there
  /// Correlation over the runs of ln NEES at the first step and at that one; NaN of fewer than ten runs.
  double kept_before_innovations = kNaN;
  /// Of each run, what NEES over its dof gains over the steps without an innovation (before the first one of
  /// all), and over the others; empty where not every step of every run is known.
  Moments growth_without_innovations = {}, growth_before_innovations = {}, growth_with_innovations = {};
  Moments growth = {};  ///< of the same runs, from the mean of the first fifth to that of the second half
  std::optional<double> measurement_noise_share = {};  ///< mean of tr(S⁻¹ R) / m
  bool nonlinear = false;                              ///< the filter linearises at its own estimates
  bool inflated = false;                               ///< it is known to inflate its covariance
  struct SensorPair {
    std::string first, second;
    BlockCorrelationTest correlation;
    double opposed_p_value = 1.0;  ///< of opposed_moments.h
  };
  std::vector<SensorPair> sensor_pairs = {};      ///< that are correlated at one step
  std::optional<double> heavy_tail_p_value = {};  ///< only where nothing speaks against the second moments
};

/// What the evidence and the judgement, but for its causes, have found.
Findings findings_of(const Evidence& evidence, const Judgement& judged);

}  // namespace credence::internal
