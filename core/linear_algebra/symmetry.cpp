#include "core/linear_algebra/symmetry.h"

#include <cmath>

namespace credence::internal {

bool is_symmetric(const Matrix& P, double tolerance) {
  for (Index i = 0; i < P.rows(); ++i) {
    for (Index j = i + 1; j < P.rows(); ++j) {
      const double scale = std::sqrt(std::abs(P(i, i) * P(j, j)));
      if (!(std::abs(P(i, j) - P(j, i)) <= tolerance * scale)) return false;
    }
  }
  return true;
}

bool make_symmetric(Matrix& P) {
  const bool symmetric = is_symmetric(P, kMostAsymmetry);
  for (Index i = 0; i < P.rows(); ++i) {
    for (Index j = i + 1; j < P.rows(); ++j) P(i, j) = P(j, i);
  }
  return symmetric;
}

}  // namespace credence::internal
