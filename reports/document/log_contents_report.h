#pragma once

#include <span>
#include <string>

#include "datasets/logs/log_contents.h"
#include "reports/document/report_table.h"

/// @file
/// What `credence check --list` says of a file.

namespace credence {

struct ListedLog {
  std::string file;
  std::string format;  ///< in words
  LogContents contents;
};

/// One row for each topic: type, count, rate, covariance or not, what it can be used as.
ReportTable contents_table(const ListedLog& log);

/// {"schema", "logs": [{"file", "format", "topics", "remark"}]} (docs/formats.md).
std::string contents_json(std::span<const ListedLog> logs);

}  // namespace credence
