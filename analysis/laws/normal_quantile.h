#pragma once

#include <boost/math/distributions/normal.hpp>

namespace credence::internal {

/// The z with P(|Z| ≤ z) = confidence, Z ~ N(0, 1).
inline double normal_quantile_two_sided(double confidence) {
  return boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * confidence);
}

}  // namespace credence::internal
