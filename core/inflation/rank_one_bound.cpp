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

double block_norm(const MatrixRef& L, Index d, Index j) { return L.middleRows(j * d, d).norm(); }

/// The bound of least trace for one distinguished landmark of norm sigma, all others together `others`.
ReductionBound least_trace(Index distinguished, double sigma, double others) {
  if (!(sigma > others)) return drop_bound();
  return {.distinguished = distinguished, .t = others / sigma, .excess = sigma - others};
}

/// block += share(j, σ_j) · L_j L_jᵀ for every block; D, M are d and the columns of L where known.
template <int D, int M, typename Share>
void add_scaled_squares_of(const MatrixRef& L, Index d, Eigen::Ref<Matrix>& blocks, Share share) {
  const Index landmarks = L.rows() / d;
  for (Index j = 0; j < landmarks; ++j) {
    const auto rows = L.block<D, M>(j * d, 0, d, L.cols());
    const double s = share(j, rows.norm());
    if (s == 0.0) continue;
    auto block = blocks.block<D, D>(0, j * d, d, d);
    for (Index b = 0; b < d; ++b) {
      block(b, b) += s * rows.row(b).squaredNorm();
      for (Index a = b + 1; a < d; ++a) {
        const double change = s * rows.row(a).dot(rows.row(b));
        block(a, b) += change;
        block(b, a) += change;
      }
    }
  }
}

template <typename Share>
void add_scaled_squares(const MatrixRef& L, Index d, Eigen::Ref<Matrix>& blocks, Share share) {
  require_blocks(L.rows(), d);
  if (blocks.rows() != d || blocks.cols() != L.rows()) {
    throw std::invalid_argument(
        fmt::format("blocks are {}x{}, not {}x{}", blocks.rows(), blocks.cols(), d, L.rows()));
  }
  if (d == 1 && L.cols() == 1) return add_scaled_squares_of<1, 1>(L, 1, blocks, share);
  if (d == 2 && L.cols() == 1) return add_scaled_squares_of<2, 1>(L, 2, blocks, share);
  add_scaled_squares_of<Eigen::Dynamic, Eigen::Dynamic>(L, d, blocks, share);
}

template <int D>
LargestNorm largest_block(const VectorRef& l, Index d) {
  LargestNorm largest;
  const Index landmarks = l.size() / d;
  for (Index j = 0; j < landmarks; ++j) largest.take(j, l.segment<D>(j * d, d).norm());
  return largest;
}

}  // namespace

ReductionBound rank_one_bound(const VectorRef& l, Index d) {
  require_blocks(l.size(), d);
  const LargestNorm largest = d == 1   ? largest_block<1>(l, 1)
                              : d == 2 ? largest_block<2>(l, 2)
                                       : largest_block<Eigen::Dynamic>(l, d);
  return least_trace(largest.at, largest.norm, largest.others);
}

ReductionBound low_rank_bound(const MatrixRef& L, Index d, Index observed, std::optional<double> t) {
  require_blocks(L.rows(), d);
  const Index landmarks = L.rows() / d;
  if (observed < 0 || observed >= landmarks) {
    throw std::invalid_argument(fmt::format("observed = {} is none of {} landmarks", observed, landmarks));
  }
  if (t && !(*t > 0.0 && *t <= 1.0)) throw std::invalid_argument(fmt::format("t = {} is not in (0, 1]", *t));
  double others = 0.0;
  for (Index j = 0; j < landmarks; ++j) {
    if (j != observed) others += block_norm(L, d, j);
  }
  if (!t) return least_trace(observed, block_norm(L, d, observed), others);
  return {.distinguished = observed, .t = *t, .excess = (1.0 / *t - 1.0) * others};
}

void add_bound(const ReductionBound& bound, const MatrixRef& L, Index d, Eigen::Ref<Matrix> blocks) {
  add_scaled_squares(L, d, blocks, [&](Index j, double sigma) { return bound.factor(j, sigma); });
}

void reduce_and_inflate(const ReductionBound& bound, const MatrixRef& L, Index d, Eigen::Ref<Matrix> blocks) {
  add_scaled_squares(L, d, blocks, [&](Index j, double sigma) {
    if (j == bound.distinguished) return bound.t - 1.0;
    return bound.excess > 0.0 && sigma > 0.0 ? bound.excess / sigma : 0.0;
  });
}

}  // namespace credence::internal
