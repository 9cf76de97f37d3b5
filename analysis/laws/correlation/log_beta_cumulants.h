#pragma once

#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/polygamma.hpp>
#include <boost/math/special_functions/trigamma.hpp>

#include "analysis/laws/chi_square/chi_square_cumulants.h"

namespace credence::internal {

/// The first three cumulants of −ln B, B ~ Beta(a, b): differences of polygamma functions at a and a + b.
inline Cumulants log_beta_cumulants(double a, double b) {
  using boost::math::digamma;
  using boost::math::polygamma;
  using boost::math::trigamma;
  return {.mean = digamma(a + b) - digamma(a),
          .variance = trigamma(a) - trigamma(a + b),
          .third = polygamma(2, a + b) - polygamma(2, a)};
}

}  // namespace credence::internal
