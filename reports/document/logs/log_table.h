#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "reports/document/logs/log_report.h"

namespace credence::internal {

/// The blocks as reports show them: the pose first, then its parts, the rest in the order of the log.
std::vector<const BlockVerdict*> blocks_in_order(const LogAnalysis& analysis);

/// The answer in a sentence, without a full stop.
std::string log_answer(const CheckedLogs& logs);

/// One row for NEES, NIS, every block, the pose first, and every sensor: verdict, mean, expected, bounds; the
/// notes say what was read and what was rejected.
ReportTable log_verdicts(const CheckedLogs& logs, std::size_t most_blocks);

/// What few need to know: tests of the innovations and of their law, what is proved.
std::vector<std::string> log_statistics(const Judgement& judgement);

/// All of it for a terminal: the verdicts, and notes on what to do and what the words mean.
ReportTable log_table(const CheckedLogs& logs);

}  // namespace credence::internal
