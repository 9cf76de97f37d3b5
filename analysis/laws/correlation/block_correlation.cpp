#include "analysis/laws/correlation/block_correlation.h"

#include <cmath>
#include <stdexcept>

#include "analysis/laws/correlation/log_beta_cumulants.h"
#include "analysis/laws/correlation/sample_correlation.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// Of −ln Λ of independent groups of p and q components over N values less their mean: Λ is a product of
/// independent Beta((N − q − i)/2, q/2), i = 1 … p ([Anderson 2003], section 8.4).
Cumulants log_lambda_cumulants(double values, Index p, Index q) {
  const double b = 0.5 * static_cast<double>(q);
  Cumulants sum;
  for (Index i = 1; i <= p; ++i)
    sum = sum + log_beta_cumulants(0.5 * (values - static_cast<double>(i)) - b, b);
  return sum;
}

}  // namespace

BlockCorrelationTest test_block_correlation(const VectorMoments& u, Index first) {
  BlockCorrelationTest result{.values = u.count, .largest = kNaN, .p_value = kNaN};
  const Index n = u.mean.size();
  if (u.count == 0) {
    result.reason = "no values";
    return result;
  }
  if (first <= 0 || first >= n) throw std::invalid_argument("both groups need a component");
  const double values = static_cast<double>(u.count), dim = static_cast<double>(n);
  if (values <= dim + 1.0) {
    result.reason = "not more values than components";
    return result;
  }
  const std::optional<Matrix> R = sample_correlation(u);
  if (!R) {
    result.reason = "a component does not vary or is not finite";
    return result;
  }
  const Index rest = n - first;
  const double log_lambda = log_determinant(*R) - log_determinant(R->topLeftCorner(first, first)) -
                            log_determinant(R->bottomRightCorner(rest, rest));
  if (std::isnan(log_lambda)) {
    result.reason = "the values are linearly dependent";
    return result;
  }
  result.largest = R->topRightCorner(first, rest).cwiseAbs().maxCoeff();
  result.p_value = upper_p_value(-log_lambda, log_lambda_cumulants(values, first, rest));
  return result;
}

}  // namespace credence::internal
