#pragma once

#include <string>
#include <vector>

#include "datasets/logs/log_format.h"
#include "reports/document/document.h"

namespace credence::internal {

struct ListedLog {
  std::string file;
  std::string format;  ///< in words
  LogContents contents;
};

/// What `credence check --list` says (JSON: docs/formats.md): of each log its topics, with type, count, rate,
/// covariance or not, and what each can be used as. For a terminal; it has no page.
Document contents_document(std::vector<ListedLog> logs);

}  // namespace credence::internal
