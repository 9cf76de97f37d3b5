#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/calibration/calibration.h"
#include "analysis/evidence/study_analysis.h"
#include "datasets/logs/pose_facts.h"
#include "datasets/logs/run_errors.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

/// @file
/// What `credence check` says of a filter's logs.

namespace credence {

/// Logs against those of an earlier version.
struct LogGate {
  std::string baseline;  ///< the file
  std::string verdict_before;
  bool became_inconsistent = false;   ///< and was not before
  std::vector<FactorChange> changes;  ///< of the factor on P, on what both logged
  std::vector<std::string> worse;     ///< sentences: what fails
};

/// Logs and where they came from.
struct CheckedLogs {
  std::string name;                 ///< for titles and files
  std::string format;               ///< in words, with how truth was found
  std::int64_t files = 0;           ///< 0: the runs lay in memory
  std::int64_t unmatched_rows = 0;  ///< estimates without a truth at their time
  LogAnalysis analysis;
  std::map<std::int64_t, std::string> failures_said{};  ///< by number of the run: what its filter said
  std::vector<std::string> remarks{};  ///< sentences: what the reader left out, or took for something
  std::vector<LogPoses> poses{};       ///< of the files that hold some
  Calibration calibration{};
  UnitFactors units{};  ///< of it
  std::optional<LogGate> gate{};
  RunErrors first_run{};  ///< of the first file; without steps where it was not kept
};

/// The blocks as reports show them: the pose first, then its parts, the rest in the order of the log.
std::vector<const BlockVerdict*> blocks_in_order(const LogAnalysis& analysis);

/// The answer in a sentence, without a full stop.
std::string log_answer(const CheckedLogs& logs);

/// One row for NEES, NIS, every block, the pose first, and every sensor: verdict, mean, expected, bounds; the
/// notes say what was read and what was rejected.
ReportTable log_verdicts(const CheckedLogs& logs, std::size_t most_blocks);

/// What few need to know: tests of the innovations and of their law, what is proved.
std::vector<std::string> log_statistics(const CheckedLogs& logs);

/// All of it for a terminal: the verdicts, and notes on what to do and what the words mean.
ReportTable log_table(const CheckedLogs& logs);

/// The document of `credence check` (docs/formats.md): keys of `credence run` with `files`, `rows` and
/// `rejected_rows`.
std::string log_json(const CheckedLogs& logs);

/// Writes DIR/index.html, DIR/NAME.csv with every step, and the figures as SVG and PDF. Throws OutputError
/// when a file cannot be written.
void write_log_report(const ReportFolder& directory, const CheckedLogs& logs,
                      const Provenance& provenance = make_provenance());

}  // namespace credence
