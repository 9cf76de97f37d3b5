#pragma once

#include <fmt/format.h>

#include "datasets/data_error.h"
#include "datasets/logs/log_format.h"

namespace credence::internal {

/// Calls `scan`, which collects what is then judged; with LogReadOptions::partial a DataError ends the
/// collecting where `anything` says that there is something, and a remark says where. Returns whether all was
/// read.
template <class Scan, class Anything>
bool read_part(const LogReadOptions& options, LogSink& sink, Scan scan, Anything anything) {
  try {
    scan();
    return true;
  } catch (const DataError& error) {
    if (!options.partial || !anything()) throw;
    sink.remark(fmt::format("only a part could be read: {}", error.what()));
    return false;
  }
}

}  // namespace credence::internal
