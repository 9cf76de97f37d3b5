#pragma once

namespace credence::internal {

/// Preconditions that the statistics share; each throws std::invalid_argument naming the value.
void require_confidence(double confidence);             ///< in (0, 1)
void require_probability(double probability);           ///< in [0, 1]
void require_fraction(const char* name, double value);  ///< in (0, 1)
void require_positive(const char* name, double value);  ///< finite and > 0

}  // namespace credence::internal
