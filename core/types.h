#pragma once

#include "core/eigen_alignment.h"

/// @file
/// Names that every folder shares.

namespace credence {

using Index = Eigen::Index;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using VectorRef = Eigen::Ref<const Vector>;
using MatrixRef = Eigen::Ref<const Matrix>;

}  // namespace credence
