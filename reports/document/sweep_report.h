#pragma once

#include <string>
#include <vector>

#include "analysis/evidence/sweep_analysis.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

namespace credence {

/// One row for each configuration of a sweep that has results. For a map of ranks
/// (analysis/studies/rank_map.h) its counts and disagreements instead.
std::vector<ReportTable> sweep_tables(const SweepAnalysis& sweep);

/// The document of `credence sweep`: configurations in the plan's order, each as `credence run` gives it; for
/// a map of ranks the map instead of them.
std::string sweep_json(const SweepAnalysis& sweep);

/// Writes DIR/index.html, DIR/sweep.csv and the figures. Throws OutputError.
void write_sweep_report(const ReportFolder& directory, const SweepAnalysis& sweep,
                        const Provenance& provenance = make_provenance());

}  // namespace credence
