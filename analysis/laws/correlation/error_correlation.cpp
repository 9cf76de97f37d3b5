#include "analysis/laws/correlation/error_correlation.h"

#include <cmath>

#include "analysis/laws/correlation/log_beta_cumulants.h"
#include "analysis/laws/correlation/sample_correlation.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// Of −ln det R of n independent components over M values less their mean: det R is a product of independent
/// Beta((M − 1 − i)/2, i/2), i = 1 … n − 1 ([Anderson 2003], section 9.3).
Cumulants log_det_cumulants(double runs, Index n) {
  Cumulants sum;
  for (Index i = 1; i < n; ++i) {
    const double b = 0.5 * static_cast<double>(i);
    sum = sum + log_beta_cumulants(0.5 * (runs - 1.0) - b, b);
  }
  return sum;
}

}  // namespace

ErrorCorrelationTest test_error_correlation(const VectorMoments& whitened) {
  ErrorCorrelationTest result{.runs = whitened.count, .largest = kNaN, .p_value = kNaN};
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
  result.p_value = upper_p_value(-log_det, log_det_cumulants(runs, n));
  return result;
}

}  // namespace credence::internal
