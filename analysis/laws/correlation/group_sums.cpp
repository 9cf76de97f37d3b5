#include "analysis/laws/correlation/group_sums.h"

namespace credence::internal {

Eigen::Map<Vector> GroupSums::next(Index dim) {
  if (groups_ == 0) sums_.resize(dim, kMost);
  if (joins()) {
    groups_ = kMost / 2;
    for (Index g = 0; g < groups_; ++g) sums_.col(g) = sums_.col(2 * g) + sums_.col(2 * g + 1);
    rows_of_group_ *= 2;
  }
  if (begins()) sums_.col(groups_++).setZero();
  ++rows_;
  return {sums_.col(groups_ - 1).data(), dim};
}

}  // namespace credence::internal
