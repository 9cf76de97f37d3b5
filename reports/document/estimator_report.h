#pragma once

#include <string>
#include <vector>

#include "analysis/studies/estimator_study.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

/// @file
/// What `credence estimators` shows: the consistency table, paired differences, JSON and a page.

namespace credence {

/// Which are consistent in their pose, in a sentence.
ReportAnswer estimator_answer(const EstimatorStudy& study);

/// One row for each estimator.
ReportTable estimator_table(const EstimatorStudy& study);

/// Errors beside the posterior Cramér-Rao bound, and beside what P says of them.
ReportTable estimator_bound_table(const EstimatorStudy& study);

/// Every estimator against one: "ideal" where it took part, else the first.
ReportTable estimator_difference_table(const EstimatorStudy& study);

/// The document of docs/formats.md.
std::string estimator_json(const EstimatorStudy& study);

/// Writes DIR/index.html and DIR/figures. Throws OutputError.
void write_estimator_report(const ReportFolder& directory, const EstimatorStudy& study,
                            const Provenance& provenance = make_provenance());

}  // namespace credence
