#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "montecarlo/engine/task_dispenser.h"

/// @file
/// What ranks tell each other.

namespace credence::internal {

struct TaskRecord {
  std::int64_t task = 0;
  std::vector<std::byte> bytes;  ///< what came of it
};

/// One message; which members it has depends on its kind.
struct RankMessage {
  enum class Kind : std::uint32_t {
    request,  ///< helper: give me tasks (identity)
    range,    ///< leader: these (range)
    records,  ///< helper: what came of tasks (records)
    leaving,  ///< helper: was asked to end; what it was given and did not send is not done
    failed,   ///< helper: something is wrong (text)
    over,     ///< leader: this phase has ended, drop what is in hand
    end,      ///< leader: nothing more will come
    bye,      ///< helper: its last message
  };

  Kind kind = Kind::request;
  std::uint64_t phase = 0;
  std::uint64_t identity = 0;  ///< of what is worked on, the same for all who may work together
  TaskRange range{};
  std::string text{};
  std::vector<TaskRecord> records{};
};

/// With the number of the format before and checksums over records.
std::vector<std::byte> to_bytes(const RankMessage& message);

/// Throws std::runtime_error for bytes that are no message of this version, or whose checksum does not fit.
RankMessage rank_message_from_bytes(std::span<const std::byte> bytes);

}  // namespace credence::internal
