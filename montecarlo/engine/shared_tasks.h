#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "montecarlo/engine/ranks.h"

/// @file
/// Tasks on all threads of all ranks: rank 0 hands them out, works itself and takes the results of all.

namespace credence::internal {

struct SharedTasks {
  std::int64_t count = 0;
  std::string identity{};                    ///< what these tasks are, which all ranks must agree on
  std::function<void(std::int64_t)> here{};  ///< does a task on rank 0 and takes its result
  std::function<std::vector<std::byte>(std::int64_t)> there{};  ///< does it for rank 0, on another rank
  std::function<void(std::int64_t, std::span<const std::byte>)> take{};  ///< takes there's result, on rank 0
  std::function<bool(std::int64_t)> wanted{};  ///< asked on rank 0, task by task in their order; none: all
  std::int64_t most_ahead = 4096;              ///< of tasks in the hands of all ranks, see TaskDispenser
  std::int64_t kept = 0;                       ///< the first so many are done on rank 0
};

/// Does every wanted task once; `here` and `take` are called by several threads at a time.
///
/// On rank 0, or without ranks, as for_each_task; `threads` are of each rank, 0 meaning one there.
/// A helper returns when rank 0 says that this work is over,
/// with nothing, and throws RanksEnded where it says that there will be no more. A helper whose `stop` is set
/// gives back what it has. Throws std::runtime_error on rank 0 if another rank reports a failure, works on
/// something else, or sends what is no result.
void for_each_shared_task(const SharedTasks& tasks, int threads, const std::atomic<bool>* stop, Ranks* ranks);

/// Thrown on a helper when rank 0 has ended. No std::exception: nothing is wrong.
struct RanksEnded {};

/// On a helper: tells rank 0 why it cannot go on.
void report_failure(Ranks& ranks, const std::string& why);

/// The last call of every rank: rank 0 ends the others, and these wait for it.
void finish_ranks(Ranks& ranks);

}  // namespace credence::internal
