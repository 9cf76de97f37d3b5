#pragma once

#include <vector>

#include "core/types.h"

namespace credence::internal {

/// A square root L of a psd matrix, A = L Lᵀ: the Cholesky factor where it exists, else from the
/// eigenvectors (negative eigenvalues, which are rounding, count as zero).
Matrix psd_root(const Matrix& A);

/// Whether a symmetric A has no negative eigenvalue, once scaled to unit diagonal, but those below
/// `tolerance` times the largest, which are rounding; a state without variance has no covariances either, and
/// all is finite.
bool is_psd(const Matrix& A, double tolerance = 1e-13);

/// The states of a covariance after a measurement that have a variance: A_ii > 1e-28 times the variance
/// before it, the square of what rounding leaves of a state that a measurement without noise has made
/// certain.
std::vector<Index> states_with_variance(MatrixRef A, VectorRef before);

/// Sets what rounding left of such states to zero, so that nobody takes it for a variance.
void clear_rounded_variances(Matrix& A, const VectorRef& before);

/// W with W A Wᵀ = I of rank A rows, so that |W e|² is the NEES of e over the directions of non-zero
/// variance: the inverse of the Cholesky factor where it exists, else the scaled eigenvectors. Its rows are
/// the dof.
///
/// The rank is that of A scaled to unit diagonal, so that it depends on no units; states without variance are
/// left out, by `before` if it is given as for states_with_variance. A is singular where a squared pivot is
/// below `tolerance` times its diagonal element, or an eigenvalue below `tolerance` times the largest.
Matrix psd_whitening(const Matrix& A, double tolerance = 1e-13);
Matrix psd_whitening(const Matrix& A, VectorRef before, double tolerance = 1e-13);

}  // namespace credence::internal
