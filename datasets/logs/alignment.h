#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// The rigid motion of the plane (no scale, no mirror) that takes `from` to `to` with the least squared
/// error.
///
/// [Umeyama 1991]. Fewer than two points fix no rotation: then the identity with the
/// mean shift. Throws std::invalid_argument for lists of unequal length.
Eigen::Isometry2d align_rigidly(const std::vector<Eigen::Vector2d>& from,
                                const std::vector<Eigen::Vector2d>& to);

/// The root of the mean squared distance between the points of two lists; 0 for empty ones.
///
/// Throws std::invalid_argument for lists of unequal length.
double rms_distance(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b);

/// rms_distance after `truth` was moved rigidly onto `estimate`: the error of a map's shape.
double rms_distance_aligned(const std::vector<Eigen::Vector2d>& truth,
                            const std::vector<Eigen::Vector2d>& estimate);

}  // namespace credence::internal
