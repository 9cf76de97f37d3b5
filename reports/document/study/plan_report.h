#pragma once

#include <vector>

#include "analysis/studies/study_plan.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence plan` says (JSON: docs/formats.md): the runs that a configuration needs and the time they
/// take; of a sweep a row for each configuration planned, and the cost of all. plans: of points of the sweep,
/// at least one; just one for a scenario without a sweep. There is no page.
Document plan_document(const SweepPlan& sweep, const std::vector<StudyPlan>& plans);

}  // namespace credence::internal
