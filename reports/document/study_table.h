#pragma once

#include <span>

#include "analysis/evidence/study_analysis.h"
#include "reports/document/report_table.h"

namespace credence {

/// One row for each study: what was run, mean and expected NEES and NIS with the bounds of the means, the
/// verdict, and how many runs failed. The notes explain the words to someone new to them.
ReportTable verdict_table(std::span<const StudyAnalysis> analyses);

/// "map, pairwise" and the like.
std::string filter_text(const FilterSettings& filter);

/// "monobot, 2 landmarks, partially observable", and with what probability they are measured if not always.
std::string world_text(const Scenario& scenario);

/// A verdict as a cell.
TableCell verdict_cell(Verdict verdict);

}  // namespace credence
