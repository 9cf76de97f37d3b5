#pragma once

#include <span>
#include <string>

#include "app/common_options.h"

namespace credence {

/// On stderr: what of the report in --out could not be drawn, and, unless --quiet, where the report is.
void tell_report(const CommonOptions& options, std::span<const std::string> problems = {});

}  // namespace credence
