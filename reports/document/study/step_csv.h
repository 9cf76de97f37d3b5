#pragma once

#include <filesystem>

#include "analysis/evidence/study_analysis.h"
#include "montecarlo/engine/experiment.h"

namespace credence::internal {

/// Every step of a study as one row: means, bounds and p-values of NEES and NIS, exact values for linear
/// models, traces of P. Throws OutputError when the file cannot be written.
void write_study_csv(const std::filesystem::path& target, const StudyAnalysis& analysis);

/// The same of logs, without what no log knows; of long runs the steps that are judged step by step.
void write_log_csv(const std::filesystem::path& target, const LogAnalysis& analysis);

/// Every step of one run as one row: true and estimated state, standard deviations, NEES, NIS. Fields of
/// landmarks not yet seen are empty.
void write_trace_csv(const std::filesystem::path& target, const RunTrace& trace);

}  // namespace credence::internal
