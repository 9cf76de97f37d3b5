#pragma once

#include "analysis/stability/stability_analysis.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence stability` says of a linear world (JSON: docs/formats.md): whether P stays bounded and what
/// that depends on, and the ranks with the singular values that they rest on. `period`: steps of the scenario
/// that are one step of the analysis.
Document stability_document(const Scenario& scenario, const StabilityAnalysis& analysis, Index period);

}  // namespace credence::internal
