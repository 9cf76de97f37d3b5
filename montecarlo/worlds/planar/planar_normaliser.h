#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/record/normalised_step.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"
#include "montecarlo/worlds/planar/planar_world.h"

namespace credence::internal {

/// Normalises what a planar filter with a matrix P shows, its blocks those of planar_layout: the joint state
/// by the factor of P that its NEES needs anyway, all blocks but the landmarks by that same factor.
class PlanarNormaliser {
 public:
  /// `variances`: of range and bearing, as the filter assumes them; empty: not known.
  PlanarNormaliser(const PlanarWorld& world, std::vector<double> variances)
      : world_(world), variances_(std::move(variances)) {}

  /// The errors of a step of these landmarks. `factor` has solved for `error` and P with a lead of 3. False
  /// where P is singular or so near it that rounding has eaten a pivot.
  bool normalise_state(const Vector& estimate, const Vector& error, const Matrix& P, const NeesSolver& factor,
                       std::span<const int> landmarks, NormalisedStep& told) const;
  /// The innovation, which may be empty; false likewise.
  bool normalise_innovation(const VectorRef& nu, const MatrixRef& S, NormalisedStep& told);

 private:
  const PlanarWorld& world_;
  std::vector<double> variances_;
  NeesSolver solver_;
};

}  // namespace credence::internal
