#include "core/filters/estimators/unscented_transform.h"

namespace credence::internal {

void semidefinite_root(Eigen::Ref<Matrix> A) {
  constexpr double kLeastPivot = 1e-14;  // relative to the variance
  for (Index j = 0; j < A.cols(); ++j) {
    const double variance = A(j, j);
    for (Index k = 0; k < j; ++k) A.col(j).tail(A.rows() - j) -= A(j, k) * A.col(k).tail(A.rows() - j);
    A.col(j).head(j).setZero();
    if (A(j, j) > kLeastPivot * variance && variance > 0.0) {
      A.col(j).tail(A.rows() - j) /= std::sqrt(A(j, j));
    } else {
      A.col(j).tail(A.rows() - j).setZero();
    }
  }
}

void divide_by_root(Eigen::Ref<Matrix> D, const MatrixRef& L) {
  for (Index j = L.cols() - 1; j >= 0; --j) {
    if (L(j, j) == 0.0) continue;
    for (Index k = j + 1; k < L.cols(); ++k) D.col(j) -= L(k, j) * D.col(k);
    D.col(j) /= L(j, j);
  }
}

void UnscentedTransform::add_moments(double c, double alpha) {
  const auto half_sums = half_sums_.matrix();
  auto shift = shift_.resize(half_sums.rows());
  shift = half_sums.rowwise().sum() / c;
  auto curvature = curvature_.resize(half_sums.rows(), half_sums.rows());
  curvature.noalias() = half_sums.lazyProduct(half_sums.transpose());
  curvature /= c;
  curvature += (2.0 - alpha * alpha) * shift.lazyProduct(shift.transpose());
}

}  // namespace credence::internal
