#pragma once

#include <stdexcept>

namespace credence::internal {

/// A result store that cannot be used: the message names the file and what to do.
struct StoreError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace credence::internal
