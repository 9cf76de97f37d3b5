#include "analysis/laws/correlation/long_lags.h"

namespace credence::internal {
namespace {

LagSeries means_of_blocks(const LagSeries& run) {
  LagSeries means(run.dim());
  Vector mean(run.dim());
  for (Index first = 0; first + LongLags::kOfBlock <= run.steps(); first += LongLags::kOfBlock) {
    const auto sum = [&](Index j) {
      double all = 0.0;
      for (Index k = first; k < first + LongLags::kOfBlock; ++k) all += run.at(j, k);
      return all;
    };
    const double values = sum(run.dim());
    if (values == 0.0) {
      means.add_missing();
      continue;
    }
    for (Index j = 0; j < mean.size(); ++j) mean[j] = sum(j) / values;
    means.add(mean);
  }
  return means;
}

}  // namespace

LongLags::LongLags(Index dim)
    : LongLags(Levels{LagProducts(dim, kLags), LagProducts(dim, kLags), LagProducts(dim, kLags)}) {}

void LongLags::add_run(const LagSeries& run) {
  levels_[0].add_run(run);
  if (run.steps() < kOfBlock) return;
  const LagSeries blocks = means_of_blocks(run);
  levels_[1].add_run(blocks);
  if (blocks.steps() >= kOfBlock) levels_[2].add_run(means_of_blocks(blocks));
}

void LongLags::merge(const LongLags& other) {
  for (std::size_t i = 0; i < levels_.size(); ++i) levels_[i].merge(other.levels_[i]);
}

LongLags LongLags::plus(const Matrix& of_each) const {
  return LongLags(Levels{levels_[0].plus(of_each), levels_[1].plus(of_each), levels_[2].plus(of_each)});
}

}  // namespace credence::internal
