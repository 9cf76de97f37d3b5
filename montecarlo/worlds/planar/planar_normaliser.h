#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/record/normalised_step.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"
#include "montecarlo/worlds/planar/planar_world.h"

namespace credence::internal {

/// What the joint law of a planar state tells of its error.
struct JointNormalised {
  NeesValue whole;
  double log_determinant = 0.0;  ///< ln det P
  double map_nees = 0.0;         ///< of the landmarks together
  bool tells_covariance = true;  ///< P is wanted
};

/// Normalises what a planar filter with a matrix P shows, its blocks those of planar_layout.
class PlanarNormaliser {
 public:
  /// `variances`: of range and bearing, as the filter assumes them; empty: not known.
  PlanarNormaliser(const PlanarWorld& world, std::vector<double> variances)
      : world_(world), variances_(std::move(variances)) {}

  /// The errors of a step of these landmarks, by a factor that has solved for `error` and P, whose lower
  /// triangle is read, with a lead of 3. False where P is singular or so near it that rounding has eaten a
  /// pivot.
  bool normalise_state(const Vector& estimate, const Vector& error, const Matrix& P, const NeesSolver& factor,
                       std::span<const int> landmarks, NormalisedStep& told) const;
  /// The same by what is known already.
  bool normalise_state(const Vector& estimate, const Vector& error, const Matrix& P,
                       const JointNormalised& joint, std::span<const int> landmarks,
                       NormalisedStep& told) const;
  /// The innovation, which may be empty; false likewise.
  bool normalise_innovation(const VectorRef& nu, const MatrixRef& S, NormalisedStep& told);

 private:
  const PlanarWorld& world_;
  std::vector<double> variances_;
  NeesSolver solver_;
};

}  // namespace credence::internal
