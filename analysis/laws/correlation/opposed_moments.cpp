#include "analysis/laws/correlation/opposed_moments.h"

#include <algorithm>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"

namespace credence::internal {

double opposed_moments_p_value(const VectorMoments& u, Index first) {
  if (u.count == 0) return 1.0;
  const Index n = u.mean.size();
  if (first <= 0 || first >= n) throw std::invalid_argument("both groups need a component");
  const double values = static_cast<double>(u.count);
  const Matrix squares = u.scatter + values * u.mean * u.mean.transpose();  // about zero
  double below = 1.0, above = 1.0;
  for (Index i = 0; i < first; ++i) {
    for (Index j = first; j < n; ++j) {
      for (const double sign : {-1.0, 1.0}) {
        const double sum = 0.5 * (squares(i, i) + squares(j, j)) + sign * squares(i, j);
        below = std::min(below, chi_square_cdf(sum, values));
        above = std::min(above, chi_square_survival(sum, values));
      }
    }
  }
  const double tests = 2.0 * static_cast<double>(first * (n - first));
  return std::min(1.0, tests * std::max(below, above));
}

}  // namespace credence::internal
