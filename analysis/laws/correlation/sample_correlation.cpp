#include "analysis/laws/correlation/sample_correlation.h"

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/logarithm.h"
#include "core/nan.h"

namespace credence::internal {

std::optional<Matrix> sample_correlation(const VectorMoments& values) {
  if (values.count < 2) return std::nullopt;
  const Vector deviation = values.scatter.diagonal().cwiseSqrt();
  if (!values.scatter.allFinite() || !(deviation.minCoeff() > 0.0)) return std::nullopt;
  const Vector scale = deviation.cwiseInverse();
  return scale.asDiagonal() * values.scatter * scale.asDiagonal();
}

double log_determinant(const Matrix& R) {
  const Eigen::LLT<Matrix> factor(R);
  return factor.info() == Eigen::Success ? log_determinant_of_factor(factor.matrixLLT()) : kNaN;
}

}  // namespace credence::internal
