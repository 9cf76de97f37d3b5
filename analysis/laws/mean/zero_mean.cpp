#include "analysis/laws/mean/zero_mean.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/mean/student.h"
#include "core/linear_algebra/cholesky.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr double kFewest = 10.0;  ///< of Hotelling's test, and of a mean that is certain

/// Hotelling's F of m and n − m dof has next to no power where n is hardly above m.
bool are_few(double n, double m) { return m > 1.0 && n < std::max(kFewest, 2.0 * m); }

// Student's t of every component, Bonferroni over them. One that is always zero tells nothing. The mean of
// one that never varies is certain of many values; few may be the same as they are rounded, which is NaN.
double p_value_of_components(const VectorMoments& moments) {
  const auto n = static_cast<double>(moments.count);
  double least = kNaN;
  for (Index i = 0; i < moments.mean.size(); ++i) {
    const double variance = moments.scatter(i, i) / (n - 1.0);
    if (variance > 0.0) {
      const double t = moments.mean[i] / std::sqrt(variance / n);
      least = std::fmin(least, student_two_sided_p_value(t, n - 1.0));
    } else if (n < kFewest) {
      return kNaN;
    } else if (moments.mean[i] != 0.0) {
      least = 0.0;
    }
  }
  return std::isnan(least) ? kNaN : std::min(1.0, static_cast<double>(moments.mean.size()) * least);
}

// Of few values: the components, and the direction in which they are largest, at half the level each.
double p_value_of_few(const VectorMoments& moments) {
  const auto n = static_cast<double>(moments.count);
  const double of_components = p_value_of_components(moments);
  const Matrix total = moments.scatter + n * moments.mean * moments.mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(0.5 * (total + total.transpose()));
  if (std::isnan(of_components) || solver.info() != Eigen::Success) return kNaN;
  const Vector w = solver.eigenvectors().col(total.cols() - 1);
  const double variance = w.dot(moments.scatter * w) / (n - 1.0);
  const double t = w.dot(moments.mean) / std::sqrt(variance / n);
  return std::min(1.0, 2.0 * std::min(of_components, student_two_sided_p_value(t, n - 1.0)));
}

}  // namespace

ZeroMeanTest test_zero_mean(const VectorMoments& moments) {
  ZeroMeanTest result;
  result.count = moments.count;
  result.mean = moments.mean;
  result.t_square = result.p_value = kNaN;
  const double n = static_cast<double>(moments.count);
  const double m = static_cast<double>(moments.mean.size());
  if (m == 0.0 || n < 2.0) {
    result.reason = "fewer than two values";
    return result;
  }
  if (!moments.mean.allFinite() || !moments.scatter.allFinite()) {
    result.reason = "a value is not finite";
    return result;
  }
  const Eigen::LLT<Matrix> factor(0.5 * (moments.scatter + moments.scatter.transpose()));
  if (are_few(n, m) || factor.info() != Eigen::Success) {
    result.p_value = are_few(n, m) ? p_value_of_few(moments) : p_value_of_components(moments);
    if (std::isnan(result.p_value)) result.reason = "the values do not vary";
    return result;
  }
  result.t_square = n * (n - 1.0) * moments.mean.dot(factor.solve(moments.mean));
  result.p_value = f_survival(result.t_square * (n - m) / (m * (n - 1.0)), m, n - m);
  return result;
}

}  // namespace credence::internal
