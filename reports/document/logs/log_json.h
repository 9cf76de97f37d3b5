#pragma once

#include <string>

#include "reports/document/logs/log_report.h"

namespace credence::internal {

/// The document of `credence check` (docs/formats.md): keys of `credence run` with `files`, `rows` and
/// `rejected_rows`.
std::string log_json(const CheckedLogs& logs);

}  // namespace credence::internal
