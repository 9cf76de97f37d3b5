#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "reports/document/report_table.h"

namespace credence {

/// What studies come to.
ReportAnswer study_answer(std::span<const StudyAnalysis> analyses);

/// The answer as its title, then one row for each study: what was run, the verdict, the factor on P, mean and
/// expected NEES, of the whole state and of the pose, NIS, and how many runs failed. The notes say what and
/// when of each filter that is not consistent, and explain the words.
ReportTable verdict_table(std::span<const StudyAnalysis> analyses);

/// What the columns and the words of the table mean, and how often they may be wrong.
std::vector<std::string> explanation_notes(std::span<const StudyAnalysis> analyses);

/// "optimistic in heading from step 180 on; times 1.3 on P the mean NEES would be right".
std::string word_clause(const Word& word, const ConsistencyVerdict& nees);

/// "planar_loop: optimistic in heading from step 180 on; times 1.3 on P the mean NEES would be right."
std::string word_sentence(const std::string& name, const Word& word, const ConsistencyVerdict& nees);

/// "map, pairwise" and the like.
std::string filter_text(const FilterSettings& filter);

/// A verdict as a cell.
TableCell verdict_cell(Verdict verdict);

}  // namespace credence
