#pragma once

#include "core/eigen_alignment.h"

/// @file
/// Names that every folder shares.

namespace credence {

using Index = Eigen::Index;                  ///< signed, of rows, steps and landmarks
using Vector = Eigen::VectorXd;              ///< n
using Matrix = Eigen::MatrixXd;              ///< n×m, by columns
using VectorRef = Eigen::Ref<const Vector>;  ///< any vector to read, or a part of one
using MatrixRef = Eigen::Ref<const Matrix>;  ///< any matrix to read, or a block of one

}  // namespace credence
