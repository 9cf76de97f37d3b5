#pragma once

#include <string>

#include "analysis/stability/planar_stability.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence stability` says of a planar world: whether the scenario's own filter stays bounded, what
/// tr P did with each solution, at the truth and in a noisy run, and what is observable along the path.
Document planar_stability_document(const Scenario& scenario, const PlanarStability& analysis);

/// Its JSON (docs/formats.md).
std::string planar_stability_json(const Scenario& scenario, const PlanarStability& analysis);

}  // namespace credence::internal
