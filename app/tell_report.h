#pragma once

#include "app/common_options.h"

namespace credence {

/// On stderr, unless --quiet: where the report of --out is.
void tell_report(const CommonOptions& options);

}  // namespace credence
