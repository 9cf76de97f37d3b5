#include "reports/figures/colour_scale.h"

#include <algorithm>
#include <cmath>

namespace credence::internal {

std::uint32_t colour_of(double share, ColourScale scale) {
  if (std::isnan(share)) return kMissingColour;
  const auto colours = scale == ColourScale::sequential ? sequential_colours() : diverging_colours();
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(colours.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), colours.size() - 2);
  const double rest = place - static_cast<double>(below);
  std::uint32_t rgb = 0;
  for (const unsigned shift : {16u, 8u, 0u}) {
    const auto channel = [shift](std::uint32_t colour) {
      return static_cast<double>((colour >> shift) & 0xFFu);
    };
    const double value = (1.0 - rest) * channel(colours[below]) + rest * channel(colours[below + 1]);
    rgb |= static_cast<std::uint32_t>(std::lround(value)) << shift;
  }
  return rgb;
}

}  // namespace credence::internal
