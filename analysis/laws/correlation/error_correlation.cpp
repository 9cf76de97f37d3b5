#include "analysis/laws/correlation/error_correlation.h"

#include <cmath>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/correlation/sample_correlation.h"
#include "core/nan.h"

namespace credence::internal {

ErrorCorrelationTest test_error_correlation(const VectorMoments& whitened) {
  ErrorCorrelationTest result{.runs = whitened.count, .largest = kNaN, .statistic = kNaN, .p_value = kNaN};
  const Index n = whitened.mean.size();
  const double runs = static_cast<double>(whitened.count);
  const double dim = static_cast<double>(n);
  if (n < 2) {
    result.reason = "fewer than two components";
    return result;
  }
  if (runs <= dim + 1.0) {
    result.reason = "not more runs than components";
    return result;
  }
  const std::optional<Matrix> R = sample_correlation(whitened);
  if (!R) {
    result.reason = "a component does not vary or is not finite";
    return result;
  }
  const double log_det = log_determinant(*R);
  if (std::isnan(log_det)) {
    result.reason = "the errors are linearly dependent";
    return result;
  }
  result.largest = (*R - Matrix::Identity(n, n)).cwiseAbs().maxCoeff();
  result.dof = 0.5 * dim * (dim - 1.0);
  result.statistic = -(runs - 1.0 - (2.0 * dim + 5.0) / 6.0) * log_det;
  result.p_value = chi_square_survival(result.statistic, result.dof);
  return result;
}

}  // namespace credence::internal
