#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "reports/render/number_text.h"

namespace credence::internal {

/// "1.06 (1.02 … 1.11)": a value with the bounds of its interval, for a person; the value alone where there
/// is no interval (NaN), as of one run.
inline std::string interval_text(double value, double lower, double upper, int significant = 3) {
  if (std::isnan(lower) && std::isnan(upper)) return number_text(value, significant);
  return fmt::format("{} ({} … {})", number_text(value, significant), number_text(lower, 3),
                     number_text(upper, 3));
}

}  // namespace credence::internal
