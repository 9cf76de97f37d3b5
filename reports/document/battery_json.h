#pragma once

#include "analysis/evidence/battery.h"
#include "reports/render/json_numbers.h"

namespace credence {

/// The object `battery` of a study (docs/formats.md).
Json battery_json(const Battery& battery);

}  // namespace credence
