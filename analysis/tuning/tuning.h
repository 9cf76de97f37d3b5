#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/tuning/score_estimate.h"
#include "core/nan.h"

/// @file
/// From log scores of data to the noise that makes them highest, with what the data can and cannot tell.

namespace credence::internal {

/// What is known of one number.
struct TunedParameter {
  std::string name;
  double before = 0.0;
  double value = kNaN;  ///< NaN where not identifiable
  /// Interval at `confidence`; where not identifiable the limits of the likelihood ratio: 0, ∞, or NaN where
  /// there are none.
  double lower = kNaN, upper = kNaN;
  double bootstrap_lower = kNaN, bootstrap_upper = kNaN;  ///< the same by resampling units, as a check
  bool identifiable = false;
  bool by_likelihood_ratio = false;    ///< the interval; else it is the normal one
  std::string reason;                  ///< why not, else empty
  double steps_for_10_percent = kNaN;  ///< until its standard error is a tenth of it

  /// The data speak against the present value: it lies outside the interval, or beyond a limit.
  bool contradicts_present() const {
    return identifiable ? !(lower <= before && before <= upper) : before < lower || before > upper;
  }
};

/// What is known before anything is tuned, from the information that data of this size hold if the present
/// filter is right.
struct TuningForecast {
  struct Parameter {
    std::string name;
    bool identifiable = false;     ///< it has an effect, and one that no others have together
    std::string reason{};          ///< why not, else empty
    double relative_error = kNaN;  ///< standard error of the estimate's logarithm
    double steps_for_10_percent = kNaN;
  };
  std::vector<Parameter> parameters;  ///< of the coordinates
  Matrix information;                 ///< of the coordinates; empty where it is not known
  double steps = 0.0;                 ///< of all data
};

/// The coordinates that the data can tell apart, found by elimination: one is held that has no information,
/// or none but what those of more information hold already, at a relative 1e-9. The information of a Gaussian
/// record is ½ tr(Σ⁻¹Σ̇_i Σ⁻¹Σ̇_j), Σ the covariance of the whole record; what each further step adds has the
/// rank of the autocovariance least-squares matrix [Odelson 2006], and what that cannot tell only the starts
/// of the runs can.
TuningForecast forecast_tuning(const ScoreModel& model, const Vector& start, double steps);

/// The present noise, the one that the data ask for, and how sure that is.
struct Tuning {
  std::vector<TunedParameter> parameters;
  TuningForecast forecast;
  std::vector<std::string> coordinates;  ///< names of those that were found
  Matrix correlation;                    ///< of the estimates of these
  Vector start, phi;                     ///< present and tuned; equal where nothing could be told
  ScoreEstimate estimate;                ///< of the coordinates that were found
  double confidence = 0.95;
  double steps = 0.0;                              ///< with a measurement
  std::int64_t units = 0;                          ///< stretches of data
  double score_before = kNaN, score_after = kNaN;  ///< mean log score of a step
  double likelihood_ratio = kNaN;                  ///< twice the gain of the sum
  Index likelihood_ratio_dof = 0;                  ///< coordinates that have moved
  double likelihood_ratio_p_value = kNaN;
  double nis_before = kNaN, nis_after = kNaN;  ///< mean of a step
  double dof = 0.0;                            ///< expected of it
  double lag_one_before = kNaN, lag_one_after = kNaN;
  bool by_sandwich = false;         ///< the intervals
  bool misspecified = false;        ///< the scores say that the tuned filter is wrong
  double information_ratio = kNaN;  ///< the worst variance of the scores over that of a right filter
  bool converged = true;            ///< else a note says how far the search got
  std::vector<std::string> notes;   ///< sentences: what is held, ridges, limits

  bool anything_known() const { return !coordinates.empty(); }
};

/// The largest ratio of an interval's ends with which a positive number still counts as identified.
inline constexpr double kWidestRatio = 100.0;
/// The largest ratio of the ends of a normal interval that is trusted.
inline constexpr double kWidestNormalRatio = 5.0;
/// Beyond this correlation of two estimates a ridge is warned of.
inline constexpr double kRidgeCorrelation = 0.95;

/// Tunes. What is not identifiable by the forecast is held. A search that ends at its bounds, a factor 1e6
/// away, is begun again there; where that does not end within a factor 1e24 nothing is known. What proves not
/// identifiable at the maximum, its curvature being not positive or its interval wider than kWidestRatio, is
/// held at its present value (at the limit of the likelihood ratio, where that excludes it), and the others
/// are sought again.
///
/// Intervals: normal ones of the logarithm by the observed information; by the sandwich [White 1982] where
/// the variance of the unit scores is larger than the information says by more than two standard errors, or
/// smaller by more than four, which says that the tuned filter is wrong, or where sensors of one step are
/// scored apart. The likelihood ratio is then taken over the mean of that variance's eigenvalues. A
/// coordinate whose normal interval is wider than kWidestNormalRatio, or would be by the forecast, has the
/// limits of the likelihood ratio instead, whose drop grows with the sandwich. Throws std::invalid_argument
/// where the present filter has no scores: an S that is not positive definite.
Tuning tune(const ScoreModel& model, const Vector& start, double confidence = 0.95);

}  // namespace credence::internal
