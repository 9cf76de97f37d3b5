#pragma once

#include <string>
#include <vector>

#include "analysis/studies/estimator_map.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/figure.h"
#include "reports/figures/paper_style.h"

/// @file
/// What `credence estimators` shows of a sweep: where which estimator is the cheapest that stays consistent.

namespace credence {

/// At how many points which estimator is enough.
ReportAnswer estimator_map_answer(const EstimatorMap& map);

/// One row for each point, titled by the answer: the cheapest, and the pose NEES of all.
ReportTable estimator_map_table(const EstimatorMap& map);

/// With two axes, the cheapest at each point by its cost, named; pose NEES of every estimator along the first
/// axis, over the worst of the other values.
std::vector<Figure> estimator_map_figures(const EstimatorMap& map);

/// The document of docs/formats.md.
std::string estimator_map_json(const EstimatorMap& map);

/// Writes DIR/index.html and DIR/figures. Throws OutputError.
void write_estimator_map_report(const ReportFolder& directory, const EstimatorMap& map,
                                const Provenance& provenance = make_provenance());

}  // namespace credence
