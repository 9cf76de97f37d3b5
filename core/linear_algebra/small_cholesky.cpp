#include "core/linear_algebra/small_cholesky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace credence::internal {
namespace {

using Sums = std::array<double, static_cast<std::size_t>(SmallCholesky::kMost)>;

/// y_i ← y_i − Σ_j L_ij factor(j), i in first … end − 1 and j in begin … stop − 1; the sum of each,
/// ascending, before it is taken from y.
template <class Factor>
inline void take_products(const double* L, Index n, Index first, Index end, Index begin, Index stop,
                          Factor factor, const double* y, double* result) {
  Sums sums;
  double* sum = sums.data();
  std::fill(sum + first, sum + end, 0.0);
  for (Index j = begin; j < stop; ++j) {
    const double* column = L + j * n;
    const double by = factor(j);
    for (Index i = first; i < end; ++i) sum[i] += column[i] * by;
  }
  for (Index i = first; i < end; ++i) result[i] = y[i] - sum[i];
}

/// Unrolled where n is a constant.
[[gnu::always_inline]] inline bool factor_lower(Index n, const double* P, Index stride, double* L) {
  for (Index k = 0; k < n; ++k) {
    const double* from = P + k * stride;
    double* column = L + k * n;
    double squares = 0.0;
    for (Index j = 0; j < k; ++j) squares += L[j * n + k] * L[j * n + k];
    const double pivot = from[k] - squares;
    if (!(pivot > 0.0 && pivot <= std::numeric_limits<double>::max())) return false;
    const double root = std::sqrt(pivot);
    column[k] = root;
    take_products(
        L, n, k + 1, n, 0, k, [&](Index j) { return L[j * n + k]; }, from, column);
    for (Index i = k + 1; i < n; ++i) column[i] /= root;
  }
  return true;
}

[[gnu::always_inline]] inline void solve_with_lower(Index n, const double* L, double* x) {
  constexpr Index kPanel = 8;  // of Eigen's solution
  for (Index begin = 0; begin < n; begin += kPanel) {
    const Index end = std::min(begin + kPanel, n);
    for (Index j = begin; j < end; ++j) {
      if (x[j] == 0.0) continue;
      const double* column = L + j * n;
      x[j] /= column[j];
      for (Index i = j + 1; i < end; ++i) x[i] -= x[j] * column[i];
    }
    if (end < n) {
      take_products(
          L, n, end, n, begin, end, [&](Index j) { return x[j]; }, x, x);
    }
  }
}

}  // namespace

bool SmallCholesky::compute(const MatrixRef& P) {
  const Index n = P.rows(), stride = P.outerStride();
  L_.resize(n, n);
  switch (n) {
    case 1:
      return factor_lower(1, P.data(), stride, L_.data());
    case 2:
      return factor_lower(2, P.data(), stride, L_.data());
    case 3:
      return factor_lower(3, P.data(), stride, L_.data());
    default:
      return factor_lower(n, P.data(), stride, L_.data());
  }
}

void SmallCholesky::solve_lower(Eigen::Ref<Vector> x) const {
  switch (L_.rows()) {
    case 1:
      return solve_with_lower(1, L_.data(), x.data());
    case 2:
      return solve_with_lower(2, L_.data(), x.data());
    case 3:
      return solve_with_lower(3, L_.data(), x.data());
    default:
      return solve_with_lower(L_.rows(), L_.data(), x.data());
  }
}

void SmallCholesky::inverse_diagonal(Vector& diagonal) const {
  const Index n = L_.rows();
  diagonal.resize(n);
  Sums column;  // of L⁻¹, whose squares add up to it
  double* x = column.data();
  for (Index first = 0; first < n; ++first) {
    std::fill(x + first, x + n, 0.0);
    x[first] = 1.0;
    double squares = 0.0;
    for (Index j = first; j < n; ++j) {
      const double* L = L_.data() + j * n;
      x[j] /= L[j];
      squares += x[j] * x[j];
      for (Index i = j + 1; i < n; ++i) x[i] -= x[j] * L[i];
    }
    diagonal[first] = squares;
  }
}

}  // namespace credence::internal
