#pragma once

#include "analysis/evidence/consistency.h"
#include "reports/render/json_numbers.h"

namespace credence {

/// A verdict with everything it rests on, as docs/formats.md describes `nees` and `nis`. Internal to the
/// writers of JSON.
Json verdict_json(const ConsistencyVerdict& verdict);

}  // namespace credence
