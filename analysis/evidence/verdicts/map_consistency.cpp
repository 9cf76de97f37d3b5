#include "analysis/evidence/verdicts/map_consistency.h"

#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"
#include "core/linear_algebra/decompositions.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

double two_sided(const NormalisedError& error) {
  return error.ok && error.dof > 0 ? two_sided_p_value(error.value, static_cast<double>(error.dof)) : kNaN;
}

/// The tangents of the rigid motions of N points: two shifts and the turn about their mean.
Matrix rigid_tangents(VectorRef points) {
  const Index n = points.size() / 2;
  Matrix J = Matrix::Zero(points.size(), 3);
  double x = 0.0, y = 0.0;
  for (Index i = 0; i < n; ++i) {
    x += points(2 * i) / static_cast<double>(n);
    y += points(2 * i + 1) / static_cast<double>(n);
  }
  for (Index i = 0; i < n; ++i) {
    J(2 * i, 0) = J(2 * i + 1, 1) = 1.0;
    J(2 * i, 2) = -(points(2 * i + 1) - y);
    J(2 * i + 1, 2) = points(2 * i) - x;
  }
  return J;
}

}  // namespace

MapConsistency judge_map(VectorRef estimate, VectorRef truth, VectorRef aligned, MatrixRef P) {
  const Index n = estimate.size();
  if (truth.size() != n || aligned.size() != n || P.rows() != n || P.cols() != n || n % 2 != 0)
    throw std::invalid_argument("judge_map: estimate, truths and P must be of one even size");
  MapConsistency result;
  result.placed_p_value = result.shape_p_value = kNaN;
  if (n == 0) {
    result.placed.reason = result.shape.reason = "the map is empty";
    return result;
  }
  result.placed = normalised_error(estimate - truth, P);
  result.placed_p_value = two_sided(result.placed);
  if (n <= 4) {
    result.shape.reason = "fewer than three landmarks";
    return result;
  }
  const Eigen::HouseholderQR<Matrix> qr(rigid_tangents(aligned));
  const Matrix Q = qr.householderQ();
  const Matrix shape = Q.rightCols(n - 3);
  const Matrix P_shape = shape.transpose() * P * shape;
  result.shape =
      normalised_error(shape.transpose() * (estimate - aligned), 0.5 * (P_shape + P_shape.transpose()));
  result.shape_p_value = two_sided(result.shape);
  return result;
}

}  // namespace credence::internal
