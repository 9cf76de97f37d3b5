#include "core/linear_algebra/small_cholesky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace credence::internal {
namespace {

using Sums = std::array<double, static_cast<std::size_t>(SmallCholesky::kMost)>;

/// y_i ← y_i − Σ_j L_ij factor(j), i in 0 … kRows − 1 and j in begin … stop − 1; the sum of each, ascending,
/// before it is taken from y, in a register.
template <Index kRows, class Factor>
[[gnu::always_inline]] inline void take_products(const double* L, Index n, Index begin, Index stop,
                                                 Factor factor, const double* y, double* result) {
  double sums[kRows] = {};
  for (Index j = begin; j < stop; ++j) {
    const double* column = L + j * n;
    const double by = factor(j);
    for (Index i = 0; i < kRows; ++i) sums[i] += column[i] * by;
  }
  for (Index i = 0; i < kRows; ++i) result[i] = y[i] - sums[i];
}

/// The same for i in first … end − 1.
template <class Factor>
[[gnu::always_inline]] inline void take_products(const double* L, Index n, Index first, Index end,
                                                 Index begin, Index stop, Factor factor, const double* y,
                                                 double* result) {
  Index i = first;
  const auto take = [&]<Index kRows>() {
    for (; i + kRows <= end; i += kRows)
      take_products<kRows>(L + i, n, begin, stop, factor, y + i, result + i);
  };
  take.template operator()<8>();
  take.template operator()<2>();
  take.template operator()<1>();
}

/// L with P = L Lᵀ; false as compute() says.
inline bool factor_lower(Index n, const double* P, Index stride, double* L) {
  for (Index k = 0; k < n; ++k) {
    double* column = L + k * n;
    take_products(
        L, n, k, n, 0, k, [&](Index j) { return L[j * n + k]; }, P + k * stride, column);
    const double pivot = column[k];
    if (!(pivot > 0.0 && pivot <= std::numeric_limits<double>::max())) return false;
    const double root = std::sqrt(pivot);
    column[k] = root;
    for (Index i = k + 1; i < n; ++i) column[i] /= root;
  }
  return true;
}

/// The same of so few rows that all of L stays in registers.
template <Index n>
inline bool factor_lower(const double* P, Index stride, double* L) {
  double l[n][n];
#pragma GCC unroll 6
  for (Index k = 0; k < n; ++k) {
#pragma GCC unroll 6
    for (Index i = k; i < n; ++i) {
      double sum = 0.0;
#pragma GCC unroll 6
      for (Index j = 0; j < k; ++j) sum += l[j][i] * l[j][k];
      l[k][i] = P[k * stride + i] - sum;
    }
    if (!(l[k][k] > 0.0 && l[k][k] <= std::numeric_limits<double>::max())) return false;
    l[k][k] = std::sqrt(l[k][k]);
#pragma GCC unroll 6
    for (Index i = k + 1; i < n; ++i) l[k][i] /= l[k][k];
#pragma GCC unroll 6
    for (Index i = k; i < n; ++i) L[k * n + i] = l[k][i];
  }
  return true;
}

inline void solve_with_lower(Index n, const double* L, double* x) {
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

/// The same of so few rows that all of x stays in registers.
template <Index n>
inline void solve_with_lower(const double* L, double* x) {
  double y[n];
  std::copy_n(x, n, y);
#pragma GCC unroll 6
  for (Index j = 0; j < n; ++j) {
    if (y[j] == 0.0) continue;
    y[j] /= L[j * n + j];
#pragma GCC unroll 6
    for (Index i = j + 1; i < n; ++i) y[i] -= y[j] * L[j * n + i];
  }
  std::copy_n(y, n, x);
}

}  // namespace

bool SmallCholesky::compute(const MatrixRef& P) {
  const Index n = P.rows(), stride = P.outerStride();
  if (L_.rows() != n) L_.resize(n, n);
  switch (n) {
    case 1: return factor_lower<1>(P.data(), stride, L_.data());
    case 2: return factor_lower<2>(P.data(), stride, L_.data());
    case 3: return factor_lower<3>(P.data(), stride, L_.data());
    case 4: return factor_lower<4>(P.data(), stride, L_.data());
    case 5: return factor_lower<5>(P.data(), stride, L_.data());
    case 6: return factor_lower<6>(P.data(), stride, L_.data());
    default: return factor_lower(n, P.data(), stride, L_.data());
  }
}

void SmallCholesky::solve_lower(Eigen::Ref<Vector> x) const {
  switch (L_.rows()) {
    case 1: return solve_with_lower<1>(L_.data(), x.data());
    case 2: return solve_with_lower<2>(L_.data(), x.data());
    case 3: return solve_with_lower<3>(L_.data(), x.data());
    case 4: return solve_with_lower<4>(L_.data(), x.data());
    case 5: return solve_with_lower<5>(L_.data(), x.data());
    case 6: return solve_with_lower<6>(L_.data(), x.data());
    default: return solve_with_lower(L_.rows(), L_.data(), x.data());
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
