#pragma once

#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/document/judged_filter.h"

namespace credence::internal {

/// Judges a scenario by its runs, and by what explains them: the further tests and the bound on the errors,
/// which `further` is for. Throws as judge_scenario.
JudgedFilter judge_study(const Scenario& scenario, const EngineOptions& runs, const EngineOptions& further);

}  // namespace credence::internal
