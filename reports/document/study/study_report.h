#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "montecarlo/engine/experiment.h"
#include "reports/document/document.h"

namespace credence::internal {

/// A study and one of its runs, to be shown.
struct ReportedStudy {
  StudyAnalysis analysis;
  std::optional<RunTrace> trace{};  ///< for the page: trace_to_draw of run_to_draw
  std::string description{};        ///< what the author of the scenario says of it
};

/// The run that is drawn: of those that the text names the first that left P behind, else the first that
/// failed behind its first step; without any run 0.
std::int64_t run_to_draw(const StudyAnalysis& analysis);

/// What `credence run` says of one study or of several: what they come to, a row for each with its verdict,
/// the factor on P, NEES and NIS, what is wrong with each filter, where and when, and what would mend it.
/// JSON: docs/formats.md. Beside the page: NAME.csv with every step and NAME-run.csv with every step of the
/// run. Precondition: there is a study.
Document study_document(std::vector<ReportedStudy> studies);

}  // namespace credence::internal
