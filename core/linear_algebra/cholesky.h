#pragma once

#include <Eigen/Cholesky>

#include "core/eigen_alignment.h"

/// @file
/// Eigen's Cholesky factorisation of matrices of any size, compiled once (decompositions.cpp); see
/// decompositions.h.

namespace Eigen {

extern template LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
extern template LLT<Ref<MatrixXd>>& LLT<Ref<MatrixXd>>::compute(const EigenBase<Ref<MatrixXd>>&);

}  // namespace Eigen
