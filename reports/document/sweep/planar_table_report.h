#pragma once

#include <vector>

#include "analysis/stability/planar_stability.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence stability` says of many planar configurations side by side (JSON: docs/formats.md), the
/// table of theory, section 5, measured: ranks, growth at the truth and in an EKF, effect of P0.
/// `analyses` belong to the points of the plan, in their order.
Document planar_table_document(const SweepPlan& plan, const std::vector<PlanarStability>& analyses);

}  // namespace credence::internal
