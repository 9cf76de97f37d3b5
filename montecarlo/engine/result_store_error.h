#pragma once

#include <stdexcept>

namespace credence::internal {

/// A result store that cannot be used: the message names the file and what to do.
struct StoreError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What to do about a store that is damaged.
inline constexpr const char* kDamageAdvice =
    "delete or move the file, and its runs are played again by the command that stored them";

}  // namespace credence::internal
