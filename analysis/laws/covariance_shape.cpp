#include "analysis/laws/covariance_shape.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/polygamma.hpp>
#include <boost/math/special_functions/trigamma.hpp>
#include <cmath>
#include <limits>

#include "analysis/laws/chi_square_cumulants.h"
#include "analysis/laws/require.h"
#include "analysis/laws/wishart_roots.h"
#include "core/nan.h"

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

CovarianceShape no_test(std::int64_t runs, std::string_view reason) {
  return {.runs = runs,
          .statistic = kNaN,
          .dof = kNaN,
          .p_value = kNaN,
          .factors = {},
          .directions = {},
          .extreme = {.optimistic = kNaN, .pessimistic = kNaN},
          .largest = {kNaN, kNaN},
          .smallest = {kNaN, kNaN},
          .proved_within = kNaN,
          .reason = reason};
}

}  // namespace

CovarianceShape test_covariance_shape(const VectorMoments& whitened, double confidence) {
  require_confidence(confidence);
  const Index n = whitened.mean.size();
  const double runs = static_cast<double>(whitened.count);
  if (n < 1) return no_test(whitened.count, "no components");
  if (whitened.count <= n) return no_test(whitened.count, "not more runs than components");
  const Matrix C = whitened.scatter / runs + whitened.mean * whitened.mean.transpose();
  if (!C.allFinite()) return no_test(whitened.count, "an error is not finite");
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(C);
  if (eigen.info() != Eigen::Success) return no_test(whitened.count, "the eigenvalues did not converge");

  CovarianceShape shape;
  shape.runs = whitened.count;
  shape.factors = eigen.eigenvalues().cwiseMax(0.0);
  shape.directions = eigen.eigenvectors();
  shape.dof = 0.5 * static_cast<double>(n * (n + 1));
  shape.statistic = runs * (shape.factors.array() - shape.factors.array().log() - 1.0).sum();
  shape.p_value = upper_p_value(shape.statistic, likelihood_ratio_cumulants(runs, n));

  const double low = shape.factors[0];
  const double high = shape.factors[n - 1];
  shape.extreme = {.optimistic = largest_root_p_value(high, runs, n),
                   .pessimistic = smallest_root_p_value(low, runs, n)};
  const double tail = 0.5 * (1.0 - confidence);
  shape.largest = {high / largest_root_quantile(tail, runs, n),
                   high * runs / chi_square_quantile(tail, runs)};
  shape.smallest = {low * runs / chi_square_upper_quantile(tail, runs),
                    low / smallest_root_quantile(tail, runs, n)};
  const double alpha = 1.0 - confidence;
  const double most = high * runs / chi_square_quantile(alpha, runs);
  const double least = low * runs / chi_square_upper_quantile(alpha, runs);
  shape.proved_within =
      least > 0.0 ? std::max(most, 1.0 / least) - 1.0 : std::numeric_limits<double>::infinity();
  return shape;
}

}  // namespace credence::internal
