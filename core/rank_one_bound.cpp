#include "core/rank_one_bound.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace credence {
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

/// Calls block += share(j, σ_j) · L_j L_jᵀ for all blocks.
template <typename Share>
void add_scaled_squares(MatrixRef L, Index d, Eigen::Ref<Matrix> blocks, Share share) {
  require_blocks(L.rows(), d);
  if (blocks.rows() != d || blocks.cols() != L.rows()) {
    throw std::invalid_argument(
        fmt::format("blocks are {}x{}, not {}x{}", blocks.rows(), blocks.cols(), d, L.rows()));
  }
  for (Index j = 0; j < L.rows() / d; ++j) {
    const double s = share(j, block_norm(L, d, j));
    if (s == 0.0) continue;
    const auto rows = L.middleRows(j * d, d);
    auto block = blocks.middleCols(j * d, d);
    for (Index b = 0; b < d; ++b) {
      for (Index a = b; a < d; ++a) {
        const double change = s * rows.row(a).dot(rows.row(b));
        block(a, b) += change;
        if (a != b) block(b, a) += change;
      }
    }
  }
}

}  // namespace

ReductionBound rank_one_bound(VectorRef l, Index d) {
  require_blocks(l.size(), d);
  Index largest = -1;
  double a_i = 0.0, others = 0.0;
  for (Index j = 0; j < l.size() / d; ++j) {
    double a = d == 1 ? std::abs(l(j)) : l.segment(j * d, d).norm();
    // The largest so far stays out of the sum, which a subtraction at the end would spoil.
    if (a > a_i) {
      std::swap(a, a_i);
      largest = j;
    }
    others += a;
  }
  return least_trace(largest, a_i, others);
}

ReductionBound low_rank_bound(MatrixRef L, Index d, Index observed, std::optional<double> t) {
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

void add_bound(const ReductionBound& bound, MatrixRef L, Index d, Eigen::Ref<Matrix> blocks) {
  add_scaled_squares(L, d, blocks, [&](Index j, double sigma) { return bound.factor(j, sigma); });
}

void reduce_and_inflate(const ReductionBound& bound, MatrixRef L, Index d, Eigen::Ref<Matrix> blocks) {
  add_scaled_squares(L, d, blocks, [&](Index j, double sigma) {
    if (j == bound.distinguished) return bound.t - 1.0;
    return bound.excess > 0.0 && sigma > 0.0 ? bound.excess / sigma : 0.0;
  });
}

}  // namespace credence
