#pragma once

#include <algorithm>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// A matrix (or with one column a vector) that keeps its memory when its size changes, where Eigen's own
/// would let it go: what a filter works with from step to step, however many landmarks it sees.
class MatrixBuffer {
 public:
  /// rows×cols; what is in it has no meaning, but that a vector made shorter keeps its first entries.
  Eigen::Map<Matrix> resize(Index rows, Index cols = 1) {
    const auto size = static_cast<std::size_t>(rows * cols);
    if (size > memory_.size()) memory_.resize(std::max(size, 2 * memory_.size()));
    rows_ = rows;
    cols_ = cols;
    return matrix();
  }

  Eigen::Map<Matrix> matrix() { return {memory_.data(), rows_, cols_}; }
  Eigen::Map<const Matrix> matrix() const { return {memory_.data(), rows_, cols_}; }

  /// The same as a vector; of one column only.
  Eigen::Map<Vector> vector() { return {memory_.data(), rows_}; }
  Eigen::Map<const Vector> vector() const { return {memory_.data(), rows_}; }

 private:
  std::vector<double> memory_;
  Index rows_ = 0, cols_ = 1;
};

}  // namespace credence::internal
