#pragma once

#include <string>

namespace credence::internal {

/// Bytes that a process may have: the memory of the machine, or less by a limit of the process (ulimit -v).
double memory_limit();

/// Throws std::invalid_argument where what is asked for needs more than memory_limit(): `what` names the keys
/// and values that need it. `bytes` is a lower bound, so that nothing is refused which can be done.
void require_memory(double bytes, const std::string& what);

}  // namespace credence::internal
