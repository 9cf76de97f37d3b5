#pragma once

#include "core/types.h"

namespace credence {

/// A square root L of a psd matrix, A = L Lᵀ: the Cholesky factor where it exists, else from the
/// eigenvectors (negative eigenvalues, which are rounding, count as zero).
Matrix psd_root(const Matrix& A);

/// W with W A Wᵀ = I of rank A rows, so that |W e|² is the NEES of e over the directions of non-zero
/// variance: the inverse of the Cholesky factor where it exists, else the scaled eigenvectors whose
/// eigenvalues exceed `tolerance` times the largest. Its rows are the dof.
Matrix psd_whitening(const Matrix& A, double tolerance = 1e-13);

}  // namespace credence
