#pragma once

#include <atomic>

namespace credence::internal {

/// From the first call on Ctrl-C, SIGTERM and SIGHUP set the flag, and say so, instead of ending the process;
/// a second one ends it. A command that is over in a moment leaves the signals alone: they end it at once.
const std::atomic<bool>& catch_interrupt();

}  // namespace credence::internal
