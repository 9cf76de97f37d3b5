#pragma once

#include <atomic>
#include <functional>

#include "datasets/logs/row_sink.h"

namespace credence::internal {

/// Runs `read` on a thread of its own, and hands what it tells its sink on to `rows` on this one, in the same
/// order: a file is read while what was read of it is added up. The sink of `read` says by waits() whether
/// this thread is the faster one, so that both get their share of what either can do.
///
/// At most a few MB, or a few rows, are read and not yet taken. What `read` throws is thrown here once all
/// that it told before was handed on; what `rows` throws ends `read` where it next tells something. `stop` is
/// asked by the stop points of `read`. Without a further thread `read` runs on this one.
void read_ahead(RowSink& rows, const std::atomic<bool>* stop, const std::function<void(RowSink&)>& read);

}  // namespace credence::internal
