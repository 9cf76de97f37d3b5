#include "analysis/laws/require.h"

#include <fmt/core.h>

#include <cmath>
#include <stdexcept>

namespace credence::internal {

void require_confidence(double confidence) { require_fraction("confidence", confidence); }

void require_probability(double probability) {
  if (!(probability >= 0.0 && probability <= 1.0)) {
    throw std::invalid_argument(fmt::format("probability = {} must lie in [0, 1]", probability));
  }
}

void require_fraction(const char* name, double value) {
  if (!(value > 0.0 && value < 1.0)) {
    throw std::invalid_argument(fmt::format("{} = {} must lie in (0, 1)", name, value));
  }
}

void require_positive(const char* name, double value) {
  if (!(std::isfinite(value) && value > 0.0)) {
    throw std::invalid_argument(fmt::format("{} = {} must be a finite number > 0", name, value));
  }
}

}  // namespace credence::internal
