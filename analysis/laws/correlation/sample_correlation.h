#pragma once

#include <optional>

#include "analysis/laws/shape/vector_moments.h"

namespace credence::internal {

/// The sample correlation of the components, n×n; nothing where one does not vary or is not finite.
std::optional<Matrix> sample_correlation(const VectorMoments& values);

/// ln det of a symmetric matrix; NaN of one that is not positive definite.
double log_determinant(const Matrix& R);

}  // namespace credence::internal
