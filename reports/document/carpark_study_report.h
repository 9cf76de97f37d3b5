#pragma once

#include <string>
#include <vector>

#include "datasets/replay/carpark_study.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

/// @file
/// The car park study as tables, JSON and a page like the paper's Figures 5 to 8.

namespace credence {

/// How much of what was to be shown holds.
ReportAnswer carpark_study_answer(const CarparkStudy& study);

/// What was to be shown and what was measured; then every variant for both P0, the independence of P0, and
/// the long horizon. Precondition: the study is complete.
std::vector<ReportTable> carpark_study_tables(const CarparkStudy& study);

/// The document of `credence replay carpark --variants` (docs/formats.md).
std::string carpark_study_json(const CarparkStudy& study);

/// Writes DIR/index.html and its figures as SVG and PDF. Throws OutputError.
void write_carpark_study_report(const ReportFolder& directory, const CarparkStudy& study,
                                const Provenance& provenance = make_provenance());

}  // namespace credence
