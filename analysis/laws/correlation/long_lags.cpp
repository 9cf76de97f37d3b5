#include "analysis/laws/correlation/long_lags.h"

#include <utility>

namespace credence::internal {

LongLags::LongLags(Index dim)
    : LongLags(Levels{LagProducts(dim, kLags), LagProducts(dim, kLags), LagProducts(dim, kLags)}) {}

LongLags::LongLags(Levels levels) : levels_(std::move(levels)) { begin_run(); }

void LongLags::begin_run() {
  for (LagProducts& level : levels_) level.begin_run();
  for (Open& open : open_) open = {.sum = Vector::Zero(dim())};
}

void LongLags::add(VectorRef u) {
  levels_[0].add(u);
  open_[1].sum += u;
  ++open_[1].values;
  count_step(1);
}

void LongLags::add_missing() {
  levels_[0].add_missing();
  count_step(1);
}

/// The mean of a block that is full goes to its level, and into the block of the next one.
void LongLags::count_step(std::size_t level) {
  Open& open = open_[level];
  if (++open.steps < kOfBlock) return;
  const bool last = level + 1 == levels_.size();
  if (open.values > 0) {
    open.sum /= static_cast<double>(open.values);
    levels_[level].add(open.sum);
    if (!last) {
      open_[level + 1].sum += open.sum;
      ++open_[level + 1].values;
    }
  } else {
    levels_[level].add_missing();
  }
  open.sum.setZero();
  open.values = open.steps = 0;
  if (!last) count_step(level + 1);
}

void LongLags::merge(const LongLags& other) {
  for (std::size_t i = 0; i < levels_.size(); ++i) levels_[i].merge(other.levels_[i]);
}

LongLags LongLags::about(const Vector& mean) const {
  return LongLags(Levels{levels_[0].about(mean), levels_[1].about(mean), levels_[2].about(mean)});
}

}  // namespace credence::internal
