#include "analysis/whiteness_innovation_mean.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/chi_square.h"

namespace credence {

void VectorMoments::add(VectorRef u) {
  if (count == 0) {
    mean = Vector::Zero(u.size());
    scatter = Matrix::Zero(u.size(), u.size());
  }
  if (u.size() != mean.size()) {
    throw std::invalid_argument(fmt::format("vector of dimension {}, expected {}", u.size(), mean.size()));
  }
  ++count;
  const Vector delta = u - mean;
  mean += delta / static_cast<double>(count);
  scatter += delta * (u - mean).transpose();
}

void VectorMoments::merge(const VectorMoments& other) {
  if (other.count == 0) return;
  if (count == 0) {
    *this = other;
    return;
  }
  if (other.mean.size() != mean.size()) {
    throw std::invalid_argument(
        fmt::format("vectors of dimension {} and {} do not merge", mean.size(), other.mean.size()));
  }
  const double na = static_cast<double>(count);
  const double nb = static_cast<double>(other.count);
  const Vector delta = other.mean - mean;
  count += other.count;
  mean += delta * (nb / (na + nb));
  scatter += other.scatter + delta * delta.transpose() * (na * nb / (na + nb));
}

InnovationMeanTest test_innovation_mean(const VectorMoments& moments) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  InnovationMeanTest result;
  result.count = moments.count;
  result.mean = moments.mean;
  result.chi_square = result.chi_square_p_value = result.t_square = result.p_value = kNaN;
  const double n = static_cast<double>(moments.count);
  const double m = static_cast<double>(moments.mean.size());
  if (n <= m || m == 0.0) {
    result.reason = "not more values than components";
    return result;
  }
  if (!moments.mean.allFinite() || !moments.scatter.allFinite()) {
    result.reason = "an innovation is not finite";
    return result;
  }
  result.chi_square = n * moments.mean.squaredNorm();
  result.chi_square_p_value = chi_square_survival(result.chi_square, m);
  const Eigen::LLT<Matrix> factor(0.5 * (moments.scatter + moments.scatter.transpose()));
  if (factor.info() != Eigen::Success) {
    result.reason = "the covariance of the innovations is singular";
    return result;
  }
  result.t_square = n * (n - 1.0) * moments.mean.dot(factor.solve(moments.mean));
  const boost::math::fisher_f law(m, n - m);
  result.p_value = cdf(complement(law, result.t_square * (n - m) / (m * (n - 1.0))));
  return result;
}

}  // namespace credence
