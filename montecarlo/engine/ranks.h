#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace credence::internal {

/// The processes that share a study: this one has the number rank() of count(), and 0 leads. Messages of one
/// rank to another arrive whole and in their order. All members may be called by several threads.
class Ranks {
 public:
  struct Message {
    int from = 0;
    std::vector<std::byte> bytes;
  };

  virtual ~Ranks() = default;
  virtual int rank() const = 0;
  virtual int count() const = 0;
  virtual void send(int to, std::span<const std::byte> message) = 0;
  virtual std::optional<Message> receive() = 0;  ///< nothing where none has arrived

  /// The number of the next piece of shared work: every rank comes to the same pieces in the same order.
  std::uint64_t next_phase() { return phase_++; }

  bool ended = false;  ///< of a helper: rank 0 has said that there will be no more

 private:
  std::uint64_t phase_ = 0;
};

/// Whether this process works for another and has no results: it stores, prints and reports nothing.
inline bool is_helper(const Ranks* ranks) { return ranks != nullptr && ranks->rank() > 0; }

}  // namespace credence::internal
