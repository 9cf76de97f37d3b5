#include "analysis/laws/shape/covariance_shape.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/polygamma.hpp>
#include <boost/math/special_functions/trigamma.hpp>
#include <cmath>
#include <limits>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/chi_square/chi_square_cumulants.h"
#include "analysis/laws/require.h"

namespace credence::internal {
namespace {

Cumulants likelihood_ratio_cumulants(double runs, Index n) {
  const double dim = static_cast<double>(n);
  double first = dim * std::log(2.0 / runs);
  double second = 0.0;
  double third = 0.0;
  for (Index i = 0; i < n; ++i) {
    const double half = 0.5 * (runs - static_cast<double>(i));
    first += boost::math::digamma(half);
    second += boost::math::trigamma(half);
    third += boost::math::polygamma(2, half);
  }
  return {.mean = -runs * first,
          .variance = runs * (runs * second - 2.0 * dim),
          .third = -runs * (runs * runs * third + 4.0 * dim)};
}

}  // namespace

CovarianceShape test_covariance_shape(const VectorMoments& whitened, double confidence) {
  require_confidence(confidence);
  const Index n = whitened.mean.size();
  const double runs = static_cast<double>(whitened.count);
  if (n < 1) return {.reason = "no components"};
  if (whitened.count <= n) return {.reason = "not more runs than components"};
  const Matrix C = whitened.scatter / runs + whitened.mean * whitened.mean.transpose();
  if (!C.allFinite()) return {.reason = "an error is not finite"};
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(C);
  if (eigen.info() != Eigen::Success) return {.reason = "the eigenvalues did not converge"};

  const Vector factors = eigen.eigenvalues().cwiseMax(0.0);
  const double ratio = runs * (factors.array() - factors.array().log() - 1.0).sum();
  const double alpha = 1.0 - confidence;
  const double most = factors[n - 1] * runs / chi_square_quantile(alpha, runs);
  const double least = factors[0] * runs / chi_square_upper_quantile(alpha, runs);
  return {.p_value = upper_p_value(ratio, likelihood_ratio_cumulants(runs, n)),
          .factors = factors,
          .proved_within =
              least > 0.0 ? std::max(most, 1.0 / least) - 1.0 : std::numeric_limits<double>::infinity()};
}

}  // namespace credence::internal
