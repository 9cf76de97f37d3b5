#pragma once

#include <atomic>

namespace credence {

/// From now on Ctrl-C and SIGTERM set the flag instead of ending the process; a second one ends it.
const std::atomic<bool>& catch_interrupt();

}  // namespace credence
