#pragma once

#include "analysis/battery.h"
#include "reports/json_numbers.h"

namespace credence {

/// The object `battery` of a study (docs/formats.md).
Json battery_json(const Battery& battery);

}  // namespace credence
