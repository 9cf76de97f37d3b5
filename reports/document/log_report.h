#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "reports/document/report_table.h"

/// @file
/// What `credence check` says of a filter's logs.

namespace credence {

/// Logs and where they came from.
struct CheckedLogs {
  std::string name;                 ///< for titles and files
  std::string format;               ///< in words, with how truth was found
  std::int64_t files = 0;           ///< 0: the runs lay in memory
  std::int64_t unmatched_rows = 0;  ///< estimates without a truth at their time
  LogAnalysis analysis;
  std::map<std::int64_t, std::string> failures_said{};  ///< by number of the run: what its filter said
  std::vector<std::string> remarks{};  ///< sentences: what the reader left out, or took for something
};

/// One row for NEES, NIS, every block and every sensor: mean, expected, bounds, verdict; the notes say what
/// was read, what was rejected, and what to do.
ReportTable log_table(const CheckedLogs& logs);

/// The document of `credence check` (docs/formats.md): keys of `credence run` with `files`, `rows` and
/// `rejected_rows`.
std::string log_json(const CheckedLogs& logs);

/// Writes DIR/index.html, DIR/<name>.csv with every step, and the figures as SVG and PDF. Throws OutputError
/// when a file cannot be written.
void write_log_report(const std::filesystem::path& directory, const CheckedLogs& logs);

}  // namespace credence
