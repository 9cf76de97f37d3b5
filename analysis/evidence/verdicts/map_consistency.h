#pragma once

#include "core/record/normalised_error.h"
#include "core/types.h"

namespace credence::internal {

/// The error of a map of N points in the plane as one vector, as it lies and up to a rigid motion.
struct MapConsistency {
  NormalisedError placed;  ///< eᵀ P⁻¹ e, 2N dof
  NormalisedError shape;   ///< the same in the 2N − 3 directions that no rigid motion of the map reaches
  double placed_p_value = 0.0, shape_p_value = 0.0;  ///< two-sided; NaN where not ok
};

/// Tests the joint error of a map against its joint covariance: one vector with many dof, so that a single
/// run supports a verdict.
///
/// `estimate` and `truth` hold x and y of each point after the other, `aligned` the truth moved rigidly onto
/// the estimate. The shape is what lies off the three tangents of a rigid motion at `aligned`: it does not
/// depend on how the map was placed and turned, to first order in the residual. Throws std::invalid_argument
/// for sizes that differ.
MapConsistency judge_map(VectorRef estimate, VectorRef truth, VectorRef aligned, MatrixRef P);

}  // namespace credence::internal
