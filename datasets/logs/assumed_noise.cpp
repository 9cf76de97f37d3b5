#include "datasets/logs/assumed_noise.h"

#include <algorithm>

namespace credence::internal {

void take_assumed_noise(const Matrix& noise, Index piece, std::span<const Index> kept, Matrix& R) {
  const Index m = noise.size() == 0 ? 0 : std::ssize(kept);
  const bool repeats =
      noise.rows() == piece && std::ranges::any_of(kept, [piece](Index i) { return i >= piece; });
  R.resize(m, m);
  for (Index i = 0; i < m; ++i) {
    for (Index j = 0; j < m; ++j) {
      const Index row = kept[static_cast<std::size_t>(i)], column = kept[static_cast<std::size_t>(j)];
      if (!repeats) {
        R(i, j) = noise(row, column);
      } else {
        R(i, j) = row / piece == column / piece ? noise(row % piece, column % piece) : 0.0;
      }
    }
  }
}

Matrix assumed_noise(const Sensor& sensor, Index measurements) {
  const Index known = std::ssize(sensor.variances);
  if (known == 0) return {};
  const bool of_piece = known == sensor.piece && measurements % known == 0;
  Vector variances(of_piece ? known : measurements);
  for (Index i = 0; i < variances.size(); ++i) {
    variances[i] = sensor.variances[static_cast<std::size_t>(i % known)];
  }
  return variances.asDiagonal();
}

}  // namespace credence::internal
