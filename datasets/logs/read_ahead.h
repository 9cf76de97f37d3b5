#pragma once

#include <atomic>
#include <functional>

#include "datasets/logs/log_sink.h"

namespace credence::internal {

/// Runs `read` on a thread of its own, and hands what it tells its sink on to `sink` on this one, in the same
/// order: a file is read while what was read of it is added up.
///
/// At most a few MB, or a few steps, are read and not yet taken. What `read` throws is thrown here once all
/// that it told before was handed on; what `sink` throws ends `read` where it next tells something. `stop` is
/// asked by the stop points of `read`. Without a further thread `read` runs on this one.
void read_ahead(LogSink& sink, const std::atomic<bool>* stop, const std::function<void(LogSink&)>& read);

}  // namespace credence::internal
