#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include "reports/document/check_logs.h"
#include "reports/document/log_report.h"

namespace credence::internal {

/// What a command wants besides.
struct CheckWatch {
  const std::atomic<bool>* stop = nullptr;           ///< set: the groups in hand are dropped
  std::function<void(std::int64_t bytes)> progress;  ///< bytes read so far, by one thread at a time
  bool keep_first_run = false;                       ///< of the first file, for the page
};

/// Reads and judges these files; where it was stopped before the first rows, there is no evidence. Throws as
/// check_logs.
CheckedLogs checked_logs(std::span<const std::filesystem::path> files, const CheckOptions& options,
                         const CheckWatch& watch = {});

}  // namespace credence::internal
