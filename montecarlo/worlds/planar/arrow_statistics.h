#pragma once

#include "core/filters/arrow_covariance.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"

/// @file
/// What the statistics of a planar filter read of an ArrowCovariance, each in O(N).

namespace credence::internal {

// Beside those of a matrix.
using credence::dense_covariance, credence::joint_nees, credence::planar_traces, credence::pose_nees;

NeesValue joint_nees(const Vector& error, const ArrowCovariance& P, NeesSolver& solver);
NeesValue pose_nees(const Vector& error, const ArrowCovariance& P, NeesSolver& solver);
PlanarTraces planar_traces(const ArrowCovariance& P);
inline Matrix dense_covariance(const ArrowCovariance& P) { return P.dense(); }

}  // namespace credence::internal
