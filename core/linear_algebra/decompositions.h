#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "core/linear_algebra/cholesky.h"
#include "core/types.h"

/// @file
/// Eigen's decompositions of matrices of any size, compiled once (decompositions.cpp).
///
/// Include this instead of Eigen's headers. What is declared here is not instantiated again in each source,
/// which costs seconds for each; the algorithms and their bits are Eigen's own. An expression as argument
/// (llt(A + B)) instantiates anew: name the matrix first.

namespace Eigen {

extern template void PartialPivLU<MatrixXd>::compute();
extern template void HouseholderQR<MatrixXd>::computeInPlace();
extern template void ColPivHouseholderQR<MatrixXd>::computeInPlace();
extern template SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(
    const EigenBase<MatrixXd>&, int);
extern template EigenSolver<MatrixXd>& EigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&, bool);
extern template ComplexSchur<MatrixXcd>& ComplexSchur<MatrixXcd>::compute(const EigenBase<MatrixXcd>&, bool);
extern template JacobiSVD<MatrixXd>& JacobiSVD<MatrixXd>::compute(const MatrixXd&, unsigned);
extern template JacobiSVD<Matrix3d>& JacobiSVD<Matrix3d>::compute(const Matrix3d&, unsigned);

}  // namespace Eigen

namespace credence::internal {

/// The first columns of the orthogonal matrix of a QR decomposition (its householderQ()).
Matrix orthonormal_columns(const Eigen::HouseholderSequence<Matrix, Vector>& Q, Index columns);

}  // namespace credence::internal
