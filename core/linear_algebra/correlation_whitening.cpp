#include "core/linear_algebra/correlation_whitening.h"

#include <cmath>
#include <limits>

namespace credence::internal {

/// kSize: n, 0: any.
template <Index kSize>
bool CorrelationWhitening::compute(const double* P, Index stride) {
  const Index n = kSize > 0 ? kSize : size_;
  double* kept = P_.data();
  bool same = true;
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i, ++kept) {
      const double value = P[j * stride + i];
      same = same && *kept == value;
      *kept = value;
    }
  }
  if (same) return whitens_;
  whitens_ = false;
  double* const scale = inverse_deviation_.data();
  for (Index i = 0; i < n; ++i) {
    const double variance = P[i * stride + i];
    if (!(variance > 0.0 && variance <= std::numeric_limits<double>::max())) return false;
    scale[i] = 1.0 / std::sqrt(variance);
  }
  double* const R = R_.data();
  for (Index j = 0; j < n; ++j) {
    R[j * n + j] = 1.0;
    for (Index i = j + 1; i < n; ++i) R[i * n + j] = R[j * n + i] = P[j * stride + i] * scale[i] * scale[j];
  }
  return whitens_ = root_.compute(n, R);
}

bool CorrelationWhitening::compute(const MatrixRef& P) {
  const Index n = P.rows();
  if (n == 0) return false;
  if (size_ != n) {
    size_ = n;
    whitens_ = false;
    const auto size = static_cast<std::size_t>(n);
    P_.assign(size * (size + 1) / 2, 0.0);  // no covariance
    R_.resize(size * size);
    inverse_deviation_.resize(size);
  }
  switch (n) {
    case 2: return compute<2>(P.data(), P.outerStride());
    case 3: return compute<3>(P.data(), P.outerStride());
    case 4: return compute<4>(P.data(), P.outerStride());
    case 6: return compute<6>(P.data(), P.outerStride());
    default: return compute<0>(P.data(), P.outerStride());
  }
}

void CorrelationWhitening::whiten(const VectorRef& error, Vector& u) const {
  u.resize(size_);
  for (Index i = 0; i < size_; ++i) u[i] = error[i] * inverse_deviation_[static_cast<std::size_t>(i)];
  root_.multiply(u.data());
}

}  // namespace credence::internal
