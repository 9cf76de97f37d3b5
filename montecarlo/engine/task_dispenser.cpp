#include "montecarlo/engine/task_dispenser.h"

#include <algorithm>

namespace credence {

TaskDispenser::TaskDispenser(std::int64_t count, int ranks, std::function<bool(std::int64_t)> wanted,
                             std::int64_t most_ahead)
    : count_(count),
      most_ahead_(most_ahead),
      wanted_(std::move(wanted)),
      given_(static_cast<std::size_t>(ranks)) {}

std::int64_t TaskDispenser::guided() const {
  const auto ranks = static_cast<std::int64_t>(given_.size());
  return std::max<std::int64_t>(1, std::min((count_ - next_) / (4 * ranks), most_ahead_ / ranks));
}

TaskRange TaskDispenser::next(int rank, std::int64_t most) {
  TaskRange range;
  if (returned_.empty()) {
    while (next_ < count_ && !wanted_(next_)) ++next_;
    range.first = next_;
    do {
      if (next_ == count_) break;
      ++next_;
      ++range.count;
    } while (range.count < most && next_ < count_ && wanted_(next_));
  } else {
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

}  // namespace credence
