#include "core/linear_algebra/inverse_root.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace credence::internal {
namespace {

constexpr double kRoundOff = std::numeric_limits<double>::epsilon();
constexpr double kNearlyThere = 1e-8;  // of an iteration whose next step is about the square of the last
constexpr Index kMostFactors = 40;
constexpr Index most_rotations(Index n) { return 8 * n * n; }

/// R whose inverse has this trace, n²/λ at the most, or eigenvalue is singular but for rounding.
bool is_singular(Index n, double least_eigenvalue) {
  return !(least_eigenvalue > 4.0 * static_cast<double>(n * n) * kRoundOff);
}

constexpr std::size_t at(Index j, Index i) { return static_cast<std::size_t>(3 * j + i); }

/// A ← −A⁻¹ of the lower triangle of a positive definite matrix, by sweeps; false where a pivot is none.
template <Index n>
inline bool sweep(double (&A)[n][n]) {
#pragma GCC unroll 6
  for (Index k = 0; k < n; ++k) {
    const double pivot = A[k][k];
    if (!(pivot > 0.0 && pivot <= std::numeric_limits<double>::max())) return false;
    const double inverse = 1.0 / pivot;
    double b[n];
#pragma GCC unroll 6
    for (Index j = 0; j < n; ++j) b[j] = j < k ? A[j][k] : A[k][j];
#pragma GCC unroll 6
    for (Index j = 0; j < n; ++j) {
      const double by = b[j] * inverse;
#pragma GCC unroll 6
      for (Index i = j; i < n; ++i) A[j][i] = j == k ? b[i] * inverse : i == k ? by : A[j][i] - b[i] * by;
    }
    A[k][k] = -inverse;
  }
  return true;
}

/// y ← y + a x.
inline void add_multiple(const double* __restrict x, double a, Index size, double* __restrict y) {
  for (Index i = 0; i < size; ++i) y[i] += a * x[i];
}

/// y ← y − a x − b z.
inline void take_multiples(const double* __restrict x, double a, const double* __restrict z, double b,
                           Index size, double* __restrict y) {
  for (Index i = 0; i < size; ++i) y[i] -= a * x[i] + b * z[i];
}

}  // namespace

template <Index n>
bool InverseRoot::iterate() {
  double M[n][n];
#pragma GCC unroll 6
  for (Index j = 0; j < n; ++j) {
#pragma GCC unroll 6
    for (Index i = j; i < n; ++i) M[j][i] = A_[static_cast<std::size_t>(j * n + i)];
  }
  double trace = static_cast<double>(n);
  const auto put = [&](double of_one, double of_matrix, const double(&matrix)[n][n]) {
    double* const factor = factors_.data() + n * n * count_++;
#pragma GCC unroll 6
    for (Index j = 0; j < n; ++j) {
      factor[j * n + j] = of_one + of_matrix * matrix[j][j];
#pragma GCC unroll 6
      for (Index i = j + 1; i < n; ++i) factor[j * n + i] = factor[i * n + j] = of_matrix * matrix[j][i];
    }
  };
  for (count_ = 0; count_ + 1 < kMostFactors;) {
    double inverse[n][n], trace_of_inverse = 0.0;
    std::copy_n(&M[0][0], n * n, &inverse[0][0]);
    if (!sweep<n>(inverse)) return false;
    for (Index i = 0; i < n; ++i) trace_of_inverse -= inverse[i][i];
    if (count_ == 0 && is_singular(n, 1.0 / trace_of_inverse)) return false;
    const double g = std::sqrt(trace_of_inverse / trace), root = std::sqrt(g);
    put(0.5 * root, -0.5 / root, inverse);
    const double of_M = 0.25 * g, of_inverse = -0.25 / g;
    double beside = 0.0;
    trace = 0.0;
#pragma GCC unroll 6
    for (Index j = 0; j < n; ++j) {
#pragma GCC unroll 6
      for (Index i = j; i < n; ++i) {
        M[j][i] = (i == j ? 0.5 : 0.0) + of_M * M[j][i] + of_inverse * inverse[j][i];
        beside = std::max(beside, std::abs(M[j][i] - (i == j ? 1.0 : 0.0)));
      }
      trace += M[j][j];
    }
    if (beside > kNearlyThere) continue;
    put(1.5, -0.5, M);  // (I + E)^{-1/2} = I − ½ E
    return true;
  }
  return false;
}

/// The eigenvectors of [1 r; r 1] are (1, 1) and (1, −1).
bool InverseRoot::of_two() {
  const double r = A_[1];
  if (is_singular(2, 0.5 * (1.0 - r) * (1.0 + r))) return false;
  const double along = 0.5 / std::sqrt(1.0 + r), across = 0.5 / std::sqrt(1.0 - r);
  factors_[0] = factors_[3] = along + across;
  factors_[1] = factors_[2] = along - across;
  count_ = 1;
  return true;
}

/// By the invariants of U = R^{1/2} ([Hoger 1984]): U³ − i₁ U² + i₂ U − i₃ I = 0 and U² = R make U⁻¹ =
/// (I + (i₁ i₂ − i₃) (i₁ R + i₃ I)⁻¹)/i₁, a sum of positive ones. i₃² = det R, i₁² = tr R + 2 i₂, and i₂ is
/// the root of i₂² = I₂ + 2 i₁ i₃ to which Newton's method falls from above, I₂ the second invariant of R.
bool InverseRoot::of_three() {
  const double a = A_[1], b = A_[2], c = A_[5];
  const double of_a = (1.0 - a) * (1.0 + a), of_b = (1.0 - b) * (1.0 + b), of_c = (1.0 - c) * (1.0 + c);
  const double below = c - a * b, determinant = of_a * of_b - below * below, second = of_a + of_b + of_c;
  if (!(of_a > 0.0) || !(of_b > 0.0) || !(of_c > 0.0) || is_singular(3, determinant / second)) return false;
  const double i3 = std::sqrt(determinant);
  double i2 = std::sqrt(second + 6.0 * i3), i1 = std::sqrt(3.0 + 2.0 * i2);
  for (double step = i2; step > kNearlyThere * i2;) {
    step = i1 * (i2 * i2 - second - 2.0 * i1 * i3) / (2.0 * (i1 * i2 - i3));
    i2 -= step;
    i1 = std::sqrt(3.0 + 2.0 * i2);
  }
  double M[3][3] = {{i1 + i3, i1 * a, i1 * b}, {0.0, i1 + i3, i1 * c}, {0.0, 0.0, i1 + i3}};
  if (!sweep<3>(M)) return false;
  const double of_one = 1.0 / i1, of_inverse = (i3 - i1 * i2) / i1;
  for (Index j = 0; j < 3; ++j) {
    factors_[at(j, j)] = of_one + of_inverse * M[j][j];
    for (Index i = j + 1; i < 3; ++i) factors_[at(j, i)] = factors_[at(i, j)] = of_inverse * M[j][i];
  }
  count_ = 1;
  return true;
}

/// R to T.
void InverseRoot::reduce() {
  const Index n = size_;
  double *const d = diagonal_.data(), *const e = beside_.data(), *const p = work_.data();
  for (Index k = 0; k + 1 < n; ++k) {
    const Index size = n - k - 1;
    double *const v = A_.data() + k * n + k + 1, *const B = A_.data() + (k + 1) * n + k + 1;
    d[k] = v[-1];
    e[k] = v[0];
    double& tau = tau_[static_cast<std::size_t>(k)];
    tau = 0.0;
    double below = 0.0;
    for (Index i = 1; i < size; ++i) below += v[i] * v[i];
    if (below == 0.0) continue;
    const double length = std::sqrt(v[0] * v[0] + below), head = v[0] >= 0.0 ? -length : length;
    const double scale = 1.0 / (v[0] - head);
    tau = (head - v[0]) / head;
    e[k] = head;
    v[0] = 1.0;
    for (Index i = 1; i < size; ++i) v[i] *= scale;
    // p = τ B v of the rest B, then B − v wᵀ − w vᵀ, w = p − ½ τ (pᵀv) v.
    std::fill_n(p, size, 0.0);
    for (Index j = 0; j < size; ++j) add_multiple(B + j * n, tau * v[j], size, p);
    double along = 0.0;
    for (Index i = 0; i < size; ++i) along += p[i] * v[i];
    add_multiple(v, -0.5 * tau * along, size, p);
    for (Index j = 0; j < size; ++j) take_multiples(v, p[j], p, v[j], size, B + j * n);
  }
  d[n - 1] = A_[static_cast<std::size_t>(n * n - 1)];
}

/// T to Λ, its rotations in their order; how many, −1 where too many do not do.
Index InverseRoot::diagonalise(Index n, double* __restrict d, double* __restrict e,
                               Rotation* __restrict rotations) {
  Index count = 0;
  e[n - 1] = 0.0;
  const auto is_whole = [&](Index i) {
    return std::abs(e[i]) > kRoundOff * (std::abs(d[i]) + std::abs(d[i + 1]));
  };
  for (Index first = 0; first + 1 < n;) {
    Index last = first;
    while (last + 1 < n && is_whole(last)) ++last;
    if (last == first) {
      ++first;
      continue;
    }
    if (count + last - first > most_rotations(n)) return -1;
    const double theta = 0.5 * (d[first + 1] - d[first]) / e[first];
    const double root = std::sqrt(1.0 + theta * theta);
    const double t = 1.0 / (theta + (theta >= 0.0 ? root : -root));
    double g = d[last] - (d[first] - t * e[first]);  // Wilkinson's shift
    double s = 1.0, c = 1.0, carried = 0.0, above = d[last];
    Index i = last - 1;
    for (; i >= first; --i) {
      const double f = s * e[i], b = c * e[i], squared = f * f + g * g, r = std::sqrt(squared);
      e[i + 1] = r;
      if (squared < std::numeric_limits<double>::min()) break;          // T has come apart
      const double inverse = r * (1.0 / squared), h = above - carried;  // beside the root, not after it
      s = f * inverse;
      c = g * inverse;
      above = d[i];
      const double q = (above - h) * s + 2.0 * c * b;
      carried = s * q;
      d[i + 1] = h + carried;
      g = c * q - b;
      rotations[count++] = {i, c, s};
    }
    d[i + 1] = above - carried;
    if (i < first) e[first] = g;
    e[last] = 0.0;
  }
  return count;
}

bool InverseRoot::compute(Index n, const double* R) {
  if (size_ != n) {
    size_ = n;
    const auto size = static_cast<std::size_t>(n), squared = size * size;
    A_.resize(squared);
    factors_.resize(n <= kFew ? static_cast<std::size_t>(kMostFactors) * squared : 0);
    rotations_.resize(n <= kFew ? 0 : static_cast<std::size_t>(most_rotations(n)));
    for (std::vector<double>* v : {&tau_, &work_, &diagonal_, &beside_}) v->resize(size);
  }
  std::copy_n(R, n * n, A_.data());
  switch (n) {
    case 1: return iterate<1>();
    case 2: return of_two();
    case 3: return of_three();
    case 4: return iterate<4>();
    case 5: return iterate<5>();
    case 6: return iterate<6>();
    default: reduce();
  }
  count_ = diagonalise(n, diagonal_.data(), beside_.data(), rotations_.data());
  if (count_ < 0 || is_singular(n, *std::min_element(diagonal_.begin(), diagonal_.end()))) return false;
  for (double& value : diagonal_) value = 1.0 / std::sqrt(value);
  return true;
}

template <Index n>
void InverseRoot::multiply_factors(double* x) const {
  const double* factor = factors_.data();
  for (Index f = 0; f < count_; ++f, factor += n * n) {
    double sums[n] = {};
#pragma GCC unroll 6
    for (Index j = 0; j < n; ++j) {
#pragma GCC unroll 6
      for (Index i = 0; i < n; ++i) sums[i] += factor[j * n + i] * x[j];
    }
    std::copy_n(sums, n, x);
  }
}

void InverseRoot::reflect(Index k, double* x) const {
  const double tau = tau_[static_cast<std::size_t>(k)];
  if (tau == 0.0) return;
  const double* v = A_.data() + k * size_;
  double along = 0.0;
  for (Index i = k + 1; i < size_; ++i) along += v[i] * x[i];
  along *= tau;
  for (Index i = k + 1; i < size_; ++i) x[i] -= along * v[i];
}

void InverseRoot::multiply_rotations(double* x) const {
  const Rotation* const begin = rotations_.data();
  for (Index k = 0; k + 2 < size_; ++k) reflect(k, x);
  for (const Rotation* r = begin; r != begin + count_; ++r) {
    const double upper = x[r->at], lower = x[r->at + 1];
    x[r->at + 1] = r->s * upper + r->c * lower;
    x[r->at] = r->c * upper - r->s * lower;
  }
  for (Index i = 0; i < size_; ++i) x[i] *= diagonal_[static_cast<std::size_t>(i)];
  for (const Rotation* r = begin + count_; r != begin;) {
    --r;
    const double upper = x[r->at], lower = x[r->at + 1];
    x[r->at] = r->c * upper + r->s * lower;
    x[r->at + 1] = r->c * lower - r->s * upper;
  }
  for (Index k = size_ - 3; k >= 0; --k) reflect(k, x);
}

void InverseRoot::multiply(double* x) const {
  switch (size_) {
    case 1: return multiply_factors<1>(x);
    case 2: return multiply_factors<2>(x);
    case 3: return multiply_factors<3>(x);
    case 4: return multiply_factors<4>(x);
    case 5: return multiply_factors<5>(x);
    case 6: return multiply_factors<6>(x);
    default: return multiply_rotations(x);
  }
}

}  // namespace credence::internal
