#pragma once

#include "montecarlo/engine/experiment.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/document/document.h"

namespace credence::internal {

/// One run: errors with their 2σ, NEES and NIS of at most some twenty steps. As JSON (docs/formats.md) truth,
/// estimate, covariance, innovation, S and gain at every step. No page.
Document trace_document(const Scenario& scenario, const RunTrace& trace);

}  // namespace credence::internal
