#pragma once

#include <string>
#include <vector>

#include "analysis/stability/stability_analysis.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

/// @file
/// What `credence stability` shows: tables, JSON and a page.

namespace credence {

/// Whether P stays bounded, and what it depends on.
ReportAnswer stability_answer(const StabilityAnalysis& analysis);

/// Ranks with their gaps, each integer beside the singular values that it rests on.
ReportTable stability_rank_table(const StabilityAnalysis& analysis);

/// Eigenvalues, Riccati limit, boundedness predicted and measured, in words and numbers.
ReportTable stability_verdict_table(const StabilityAnalysis& analysis);

/// The document of docs/formats.md.
std::string stability_json(const Scenario& scenario, const StabilityAnalysis& analysis);

/// Writes DIR/index.html and DIR/figures. Throws OutputError when a file cannot be written.
void write_stability_report(const ReportFolder& directory, const Scenario& scenario,
                            const StabilityAnalysis& analysis,
                            const Provenance& provenance = make_provenance());

}  // namespace credence
