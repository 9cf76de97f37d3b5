#pragma once

#include <limits>
#include <vector>

#include "analysis/tuning/maximise.h"
#include "analysis/tuning/score_model.h"

namespace credence::internal {

/// The maximum of a score with its curvature.
struct ScoreEstimate {
  Vector phi{};
  double value = 0.0;         ///< sum of the scores
  std::vector<Index> free{};  ///< coordinates that were sought; the matrices below are of these
  Matrix information{};       ///< observed: −∂²value, by central differences of the gradient
  Matrix unit_scores{};       ///< of each unit, in columns
  double decrement = 0.0;     ///< gᵀ A⁻¹ g at phi: what is left, in units of the sum
  bool ok = false;            ///< false: no scores at the start

  /// A⁻¹; empty where the information is not positive definite.
  Matrix covariance{};

  /// A⁻¹ B A⁻¹, B = Σ g gᵀ over the units: the covariance of the estimate also where the filter is not right
  /// [White 1982].
  Matrix sandwich() const;
};

/// Maximises and then makes Newton steps until a step gains less than 1e-6. Where the curvature is not
/// positive definite there is no covariance. `scale` as for maximise.
ScoreEstimate estimate_score(const ScoreModel& model, const Vector& start, const SearchBox& box,
                             const std::vector<bool>& free, const Vector& scale);

/// The highest sum of scores with one coordinate held at `value`, the others sought from `start` on.
Maximum profile_score(const ScoreModel& model, Vector start, const SearchBox& box, std::vector<bool> free,
                      const Vector& scale, Index coordinate, double value);

/// Where the profile of a coordinate falls by `drop` below the maximum: the interval of the likelihood ratio.
/// Infinite where it does not within the box.
struct ProfileLimits {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};
ProfileLimits profile_limits(const ScoreModel& model, const ScoreEstimate& estimate, const SearchBox& box,
                             const std::vector<bool>& free, const Vector& scale, Index coordinate,
                             double drop);

}  // namespace credence::internal
