#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <vector>

namespace credence::internal {

/// Tasks first … first + count − 1.
struct TaskRange {
  std::int64_t first = 0, count = 0;
};

/// Which of the tasks 0 … count − 1 nobody has yet, and who has the others. Not synchronised.
///
/// Guided self-scheduling [Polychronopoulos 1987]: a rank is given 1/4 of its share of what is left, at least
/// one task, so that ranges are long at first and none is long at the end.
class TaskDispenser {
 public:
  /// wanted(i): asked before a task is first given out; false: it needs not be done. `most_ahead`: about so
  /// many tasks are in the hands of all ranks together, which bounds the results that wait for earlier ones.
  /// `kept`: the first so many tasks are given to rank 0 alone.
  TaskDispenser(std::int64_t count, int ranks, std::function<bool(std::int64_t)> wanted,
                std::int64_t most_ahead, std::int64_t kept = 0);

  /// The next tasks for a rank, at most so many; none where nothing is left.
  TaskRange next(int rank, std::int64_t most);

  /// How many tasks a rank is given now.
  std::int64_t guided() const;

  /// Whether a rank has been given this task and has not done it.
  bool holds(int rank, std::int64_t task) const;
  void done(int rank, std::int64_t task);

  /// Takes back what a rank has.
  void give_back(int rank);

  bool has_returned() const { return !returned_.empty(); }
  bool all_done() const { return given_count_ == 0 && returned_.empty(); }  ///< but for what next() has

 private:
  TaskRange take(std::int64_t& next, std::int64_t end, std::int64_t most);

  std::int64_t count_, kept_, next_kept_ = 0, next_, most_ahead_, given_count_ = 0;
  std::function<bool(std::int64_t)> wanted_;
  std::set<std::int64_t> returned_;
  std::vector<std::set<std::int64_t>> given_;  ///< by rank
};

}  // namespace credence::internal
