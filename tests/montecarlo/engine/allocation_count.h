#pragma once

#include <cstdint>

namespace credence::internal {

/// Allocations of this thread so far: malloc, calloc, realloc and operator new, as the libraries call them.
std::int64_t allocations_of_this_thread();

}  // namespace credence::internal
