#pragma once

#include "analysis/studies/filter_timing.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence timing` says (JSON: docs/formats.md): how the time of a step grows with the map, from where
/// on the O(N) filter is the faster one, and how fast Monte Carlo is. Beside the page: timing.json.
Document timing_document(const TimingResult& result);

}  // namespace credence::internal
