#pragma once

#include <span>
#include <string>

#include "analysis/studies/study_plan.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "reports/document/report_table.h"

namespace credence {

/// The document of `credence plan` (docs/formats.md); plans: of points of the sweep, the first for a
/// scenario without one.
std::string plan_json(const SweepPlan& sweep, std::span<const StudyPlan> plans);

/// One configuration: what is asked and the runs and the time it takes.
ReportTable plan_table(const StudyPlan& plan);

/// A sweep: the same in one row for each configuration that was planned, and the cost of all.
ReportTable plan_table(const SweepPlan& sweep, std::span<const StudyPlan> plans);

}  // namespace credence
