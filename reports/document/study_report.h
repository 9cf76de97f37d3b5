#pragma once

#include <span>
#include <string>

#include "analysis/evidence/study_analysis.h"
#include "montecarlo/engine/experiment.h"
#include "reports/document/provenance.h"
#include "reports/figures/paper_style.h"

namespace credence {

/// A study and one of its runs, to be shown.
struct ReportedStudy {
  StudyAnalysis analysis;
  RunTrace trace;
  std::string description{};  ///< what the author of the scenario says of it
};

/// The name of the one study, or the question that several answer.
std::string report_title(std::span<const ReportedStudy> studies);

/// Writes DIR/index.html with all studies and, for each, NAME.csv, NAME-run.csv, and its figures as SVG
/// and PDF in DIR/figures.
///
/// Throws OutputError when a file cannot be written; no file is left half-written.
void write_study_report(const ReportFolder& directory, const std::string& title,
                        std::span<const ReportedStudy> studies,
                        const Provenance& provenance = make_provenance());

/// A verdict in words: its number, bounds, p-value and how many tests were made.
std::string verdict_sentence(const char* what, const ConsistencyVerdict& verdict);

}  // namespace credence
