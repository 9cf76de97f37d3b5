#include "core/inflation/rank_one_bound.h"

#include <fmt/format.h>

#include <stdexcept>

namespace credence::internal {
namespace {

void require_blocks(Index rows, Index d) {
  if (d < 1 || rows % d != 0) {
    throw std::invalid_argument(fmt::format("{} rows cannot be cut into blocks of {}", rows, d));
  }
}

template <int D>
LargestNorm largest_block(const VectorRef& l, Index d) {
  LargestNorm largest;
  const Index landmarks = l.size() / d;
  for (Index j = 0; j < landmarks; ++j) largest.take(j, l.segment<D>(j * d, d).norm());
  return largest;
}

/// D is d where it is known.
template <int D>
void reduce_and_inflate_blocks(const ReductionBound& bound, const VectorRef& l, Index d,
                               Eigen::Ref<Matrix>& blocks) {
  const Index landmarks = l.size() / d;
  for (Index j = 0; j < landmarks; ++j) {
    const auto l_j = l.segment<D>(j * d, d);
    const double a_j = l_j.norm();
    const double share = j == bound.distinguished          ? bound.t - 1.0
                         : bound.excess > 0.0 && a_j > 0.0 ? bound.excess / a_j
                                                           : 0.0;
    if (share == 0.0) continue;
    auto block = blocks.block<D, D>(0, j * d, d, d);
    for (Index b = 0; b < d; ++b) {
      block(b, b) += share * (l_j[b] * l_j[b]);
      for (Index a = b + 1; a < d; ++a) {
        const double change = share * (l_j[a] * l_j[b]);
        block(a, b) += change;
        block(b, a) += change;
      }
    }
  }
}

}  // namespace

ReductionBound rank_one_bound(const VectorRef& l, Index d) {
  require_blocks(l.size(), d);
  const LargestNorm largest = d == 1   ? largest_block<1>(l, 1)
                              : d == 2 ? largest_block<2>(l, 2)
                                       : largest_block<Eigen::Dynamic>(l, d);
  if (!largest.dominates()) return {};
  return {.distinguished = largest.at,
          .t = largest.others / largest.norm,
          .excess = largest.norm - largest.others};
}

void reduce_and_inflate(const ReductionBound& bound, const VectorRef& l, Index d, Eigen::Ref<Matrix> blocks) {
  require_blocks(l.size(), d);
  if (blocks.rows() != d || blocks.cols() != l.size()) {
    throw std::invalid_argument(
        fmt::format("blocks are {}x{}, not {}x{}", blocks.rows(), blocks.cols(), d, l.size()));
  }
  if (d == 1) return reduce_and_inflate_blocks<1>(bound, l, d, blocks);
  if (d == 2) return reduce_and_inflate_blocks<2>(bound, l, d, blocks);
  reduce_and_inflate_blocks<Eigen::Dynamic>(bound, l, d, blocks);
}

}  // namespace credence::internal
