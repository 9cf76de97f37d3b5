#pragma once

#include <span>
#include <string>

#include "analysis/stability/planar_stability.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

/// @file
/// The stability of many planar configurations side by side: the table of theory, section 5, measured.

namespace credence {

/// One row for each configuration and solution: ranks, growth at the truth and in an EKF, effect of P0.
/// `analyses` belong to the points of the plan, in their order.
ReportTable planar_stability_table(const SweepPlan& plan, std::span<const PlanarStability> analyses);

/// Each configuration as `credence stability` gives it alone, with `swept`.
std::string planar_stability_table_json(const SweepPlan& plan, std::span<const PlanarStability> analyses);

/// Writes DIR/index.html; OutputError when it cannot be written.
void write_planar_stability_table(const ReportFolder& directory, const SweepPlan& plan,
                                  std::span<const PlanarStability> analyses,
                                  const Provenance& provenance = make_provenance());

}  // namespace credence
