#include "analysis/laws/zero_mean.h"

#include <boost/math/distributions/fisher_f.hpp>

#include "core/linear_algebra/cholesky.h"
#include "core/nan.h"

namespace credence::internal {

ZeroMeanTest test_zero_mean(const VectorMoments& moments) {
  ZeroMeanTest result;
  result.count = moments.count;
  result.mean = moments.mean;
  result.t_square = result.p_value = kNaN;
  const double n = static_cast<double>(moments.count);
  const double m = static_cast<double>(moments.mean.size());
  if (n <= m || m == 0.0) {
    result.reason = "not more values than components";
    return result;
  }
  if (!moments.mean.allFinite() || !moments.scatter.allFinite()) {
    result.reason = "a value is not finite";
    return result;
  }
  const Eigen::LLT<Matrix> factor(0.5 * (moments.scatter + moments.scatter.transpose()));
  if (factor.info() != Eigen::Success) {
    result.reason = "the covariance of the values is singular";
    return result;
  }
  result.t_square = n * (n - 1.0) * moments.mean.dot(factor.solve(moments.mean));
  const boost::math::fisher_f law(m, n - m);
  result.p_value = cdf(complement(law, result.t_square * (n - m) / (m * (n - 1.0))));
  return result;
}

}  // namespace credence::internal
