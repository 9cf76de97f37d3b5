#pragma once

#include "analysis/consistency.h"
#include "reports/json_numbers.h"

namespace credence {

/// A verdict with everything it rests on, as docs/formats.md describes `nees` and `nis`. Internal to the
/// writers of JSON.
Json verdict_json(const ConsistencyVerdict& verdict);

}  // namespace credence
