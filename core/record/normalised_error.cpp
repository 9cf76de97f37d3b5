#include "core/record/normalised_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/linear_algebra/decompositions.h"
#include "core/nan.h"
#include "core/record/certain_states.h"

namespace credence::internal {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kNegative = 1e-12;  // of an eigenvalue of a P that many steps have rounded

NormalisedError failure(std::string_view reason) {
  NormalisedError result;
  result.reason = reason;
  result.value = kNaN;
  return result;
}

// Fills whitened along the eigenvectors with an eigenvalue above the rounding level; false if indefinite.
bool whiten_on_range(const Matrix& correlation, const Vector& scaled, bool& leaves_range,
                     NormalisedError& result) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(correlation);
  if (eigen.info() != Eigen::Success) return false;
  const double n = static_cast<double>(correlation.rows());
  const double largest = eigen.eigenvalues().maxCoeff(), tolerance = 4.0 * n * kEpsilon * largest;
  if (eigen.eigenvalues().minCoeff() < -std::max(tolerance, kNegative * largest)) return false;
  const Vector along = eigen.eigenvectors().transpose() * scaled;
  const double size = std::max(1.0, scaled.cwiseAbs().maxCoeff());
  std::vector<double> whitened;
  for (Index i = 0; i < along.size(); ++i) {
    const double lambda = eigen.eigenvalues()(i);
    if (lambda > tolerance) {
      whitened.push_back(along(i) / std::sqrt(lambda));
    } else if (std::abs(along(i)) > kCertainError * size) {
      leaves_range = true;
    }
  }
  result.whitened = Eigen::Map<const Vector>(whitened.data(), static_cast<Index>(whitened.size()));
  return true;
}

// A Cholesky factor whose smallest pivot shows a rank beyond rounding.
bool has_full_rank(const Eigen::LLT<Matrix>& factor, Index n) {
  if (factor.info() != Eigen::Success) return false;
  const double smallest = factor.matrixLLT().diagonal().minCoeff();
  return smallest * smallest > 100.0 * static_cast<double>(n) * kEpsilon;
}

}  // namespace

NormalisedError normalised_error(VectorRef error, MatrixRef P) {
  const Index n = error.size();
  if (P.rows() != n || P.cols() != n) {
    throw std::invalid_argument(
        fmt::format("error of dimension {} and P of {}x{} do not fit", n, P.rows(), P.cols()));
  }
  if (!P.allFinite()) return failure("the covariance is not finite");
  if (!error.allFinite()) return failure("the error is not finite");

  NormalisedError result;
  bool leaves_range = false;
  std::vector<Index> kept;
  for (Index i = 0; i < n; ++i) {
    if (P(i, i) < 0.0) return failure("the covariance has a negative variance");
    if (P(i, i) > 0.0) {
      kept.push_back(i);
      continue;
    }
    // |P_ij|² ≤ P_ii P_jj: a covariance with a known state must be zero.
    if (P.row(i).cwiseAbs().maxCoeff() > 0.0) return failure("a zero variance has a covariance");
    leaves_range = leaves_range || std::abs(error(i)) > kCertainError;
  }

  const Index m = static_cast<Index>(kept.size());
  Matrix correlation(m, m);
  Vector scaled(m);
  for (Index i = 0; i < m; ++i) {
    const double deviation =
        std::sqrt(P(kept[static_cast<std::size_t>(i)], kept[static_cast<std::size_t>(i)]));
    scaled(i) = error(kept[static_cast<std::size_t>(i)]) / deviation;
    for (Index j = 0; j < m; ++j) {
      const Index row = kept[static_cast<std::size_t>(i)];
      const Index col = kept[static_cast<std::size_t>(j)];
      correlation(i, j) = P(row, col) / (deviation * std::sqrt(P(col, col)));
    }
  }
  if (m > 0) {
    const Eigen::LLT<Matrix> factor(correlation);
    if (has_full_rank(factor, m)) {
      result.whitened = factor.matrixL().solve(scaled);
    } else if (!whiten_on_range(correlation, scaled, leaves_range, result)) {
      return failure("the covariance is not positive semidefinite");
    }
  }
  result.ok = true;
  result.dof = result.whitened.size();
  result.value = leaves_range ? std::numeric_limits<double>::infinity() : result.whitened.squaredNorm();
  return result;
}

}  // namespace credence::internal
