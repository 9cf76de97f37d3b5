#pragma once

#include <filesystem>
#include <map>
#include <span>

#include "datasets/logs/log_format.h"
#include "reports/document/logs/check_logs.h"
#include "reports/document/logs/log_report.h"

namespace credence::internal {

/// The format of every file, by name or from how the file begins. Throws as check_logs.
std::map<std::filesystem::path, const LogFormat*> formats_of(std::span<const std::filesystem::path> files,
                                                             const CheckOptions& options);

/// Reads and judges these files; where it was stopped before the first rows, there is no evidence.
/// `keep_first_run`: of the first file, for the page. Throws as check_logs.
CheckedLogs checked_logs(std::span<const std::filesystem::path> files, const CheckOptions& options,
                         bool keep_first_run);

}  // namespace credence::internal
