#pragma once

#include <string>
#include <vector>

#include "analysis/stability/planar_stability.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

/// @file
/// What `credence stability` shows of a planar world: tables, JSON and a page.

namespace credence {

/// Whether the scenario's own filter stays bounded, at the truth and in a noisy run.
ReportAnswer planar_stability_answer(const Scenario& scenario, const PlanarStability& analysis);

/// Rank of the observability matrix along the path, at the truth and at the filter's estimates.
ReportTable planar_rank_table(const PlanarStability& analysis);

/// One row for each solution and linearisation: what tr P did, what the accumulated noise predicts, NEES.
ReportTable planar_growth_table(const Scenario& scenario, const PlanarStability& analysis);

/// The document of docs/formats.md.
std::string planar_stability_json(const Scenario& scenario, const PlanarStability& analysis);

/// Writes DIR/index.html and DIR/figures. Throws OutputError.
void write_planar_stability_report(const ReportFolder& directory, const Scenario& scenario,
                                   const PlanarStability& analysis,
                                   const Provenance& provenance = make_provenance());

}  // namespace credence
