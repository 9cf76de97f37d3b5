#include "montecarlo/engine/task_dispenser.h"

#include <algorithm>

namespace credence::internal {

TaskDispenser::TaskDispenser(std::int64_t count, int ranks, std::function<bool(std::int64_t)> wanted,
                             std::int64_t most_ahead, std::int64_t kept)
    : count_(count),
      kept_(std::min(kept, count)),
      next_(kept_),
      most_ahead_(most_ahead),
      wanted_(std::move(wanted)),
      given_(static_cast<std::size_t>(ranks)) {}

std::int64_t TaskDispenser::guided() const {
  const auto ranks = static_cast<std::int64_t>(given_.size());
  return std::max<std::int64_t>(1, std::min((count_ - next_) / (4 * ranks), most_ahead_ / ranks));
}

TaskRange TaskDispenser::take(std::int64_t& next, std::int64_t end, std::int64_t most) {
  while (next < end && !wanted_(next)) ++next;
  TaskRange range{.first = next};
  do {
    if (next == end) break;
    ++next;
    ++range.count;
  } while (range.count < most && next < end && wanted_(next));
  return range;
}

TaskRange TaskDispenser::next(int rank, std::int64_t most) {
  TaskRange range;
  if (rank == 0) range = take(next_kept_, kept_, most);
  if (range.count == 0 && returned_.empty()) {
    range = take(next_, count_, most);
  } else if (range.count == 0) {
    range.first = *returned_.begin();
    while (range.count < most && returned_.erase(range.first + range.count) == 1) ++range.count;
  }
  auto& given = given_[static_cast<std::size_t>(rank)];
  for (std::int64_t i = 0; i < range.count; ++i) given.insert(given.end(), range.first + i);
  given_count_ += range.count;
  return range;
}

bool TaskDispenser::holds(int rank, std::int64_t task) const {
  return given_[static_cast<std::size_t>(rank)].contains(task);
}

void TaskDispenser::done(int rank, std::int64_t task) {
  given_count_ -= static_cast<std::int64_t>(given_[static_cast<std::size_t>(rank)].erase(task));
}

void TaskDispenser::give_back(int rank) {
  auto& given = given_[static_cast<std::size_t>(rank)];
  given_count_ -= static_cast<std::int64_t>(given.size());
  returned_.merge(given);
}

}  // namespace credence::internal
