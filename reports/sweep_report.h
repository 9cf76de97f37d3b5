#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "analysis/study_analysis.h"
#include "montecarlo/sweep_plan.h"
#include "reports/report_table.h"

namespace credence {

/// One row for each configuration of a sweep that has results; `analyses` follow the points of the plan. For
/// a map of ranks (analysis/rank_map.h) its counts and disagreements instead.
std::vector<ReportTable> sweep_tables(const SweepPlan& plan, std::span<const StudyAnalysis> analyses);

/// The document of `credence sweep`: configurations in the plan's order, each as `credence run` gives it; for
/// a map of ranks the map instead of them.
std::string sweep_json(const SweepPlan& plan, std::span<const StudyAnalysis> analyses);

/// Writes DIR/index.html, DIR/sweep.csv and the figures. Returns why figures could not be drawn. Throws
/// OutputError.
std::vector<std::string> write_sweep_report(const std::filesystem::path& directory, const SweepPlan& plan,
                                            std::span<const StudyAnalysis> analyses);

}  // namespace credence
