#include "analysis/evidence/sums/run_samples.h"

namespace credence::internal {

void RunSamples::add(const Vector& error, const Vector& variance) {
  const Index dim = error.size();
  if (rows_ == 0 && dim <= kLargest) {
    samples_.resize(dim, kMost);
    log_variances_.resize(kMost);
  }
  if (dim != samples_.rows() || !(variance.minCoeff() > 0.0)) return;
  if ((rows_++ & (every_ - 1)) != 0) return;
  if (count_ == kMost) {
    for (Index i = 0; i < kMost / 2; ++i) {
      samples_.col(i) = samples_.col(2 * i).eval();
      log_variances_[i] = log_variances_[2 * i];
    }
    count_ = kMost / 2;
    every_ *= 2;
  }
  samples_.col(count_) = error.array() / variance.array().sqrt();
  log_variances_[count_++] = variance.array().log().mean();
}

Matrix RunSamples::errors(Index most) const {
  Index stride = 1;
  while ((count_ + stride - 1) / stride > most) stride *= 2;
  Matrix some(samples_.rows(), (count_ + stride - 1) / stride);
  for (Index i = 0; i < some.cols(); ++i) some.col(i) = samples_.col(i * stride);
  return some;
}

}  // namespace credence::internal
