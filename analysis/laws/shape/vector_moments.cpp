#include "analysis/laws/shape/vector_moments.h"

#include <fmt/format.h>

#include <stdexcept>

namespace credence::internal {

void VectorMoments::add(VectorRef u) {
  if (count == 0) {
    mean = Vector::Zero(u.size());
    scatter = Matrix::Zero(u.size(), u.size());
  }
  if (u.size() != mean.size()) {
    throw std::invalid_argument(fmt::format("vector of dimension {}, expected {}", u.size(), mean.size()));
  }
  ++count;
  const double n = static_cast<double>(count);
  if (delta_.size() != u.size()) delta_.resize(u.size());
  for (Index i = 0; i < u.size(); ++i) {
    delta_[i] = u[i] - mean[i];
    mean[i] += delta_[i] / n;
  }
  for (Index j = 0; j < u.size(); ++j) {
    const double after = u[j] - mean[j];
    for (Index i = 0; i < u.size(); ++i) scatter(i, j) += delta_[i] * after;
  }
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

}  // namespace credence::internal
