#pragma once

#include <cstdint>

#include "reports/figures/figure.h"

namespace credence::internal {

/// The colour at `share` of a scale, from 0 (low) to 1 (high), linear between its colours; beyond an end the
/// colour of that end, and the colour of missing values for NaN.
std::uint32_t colour_of(double share, ColourScale scale);

}  // namespace credence::internal
