#pragma once

#include <string>
#include <vector>

#include "core/record/block_layout.h"
#include "core/types.h"

/// @file
/// What cannot be observed, in the words of the state.

namespace credence::internal {

/// A direction of the state space with its name.
struct NamedDirection {
  std::string name;
  Vector direction;  ///< of norm one
};

/// Names of the unobservable directions of a SLAM state.
///
///   one dimension:  "common translation"
///   the plane:      "common translation x", "common translation y", "rotation about the origin",
///                   "rotation about the anchor (x, y)", "rotation about the point (x, y)",
///                   "common translation along (c, s)"
///   else            the listing of the largest components, "0.71 r, −0.71 f2"
///
/// `unobservable` has orthonormal columns (`ObservabilityAnalysis`), n×k with n = layout.state_dim(). The
/// plane is a layout with vehicle = 3 and landmark = 2; its rotations need the state `linearisation_point`
/// (metres, rad) at which the directions hold, n×1, and are not looked for if it is empty. `anchors` is 2×a.
/// Returns k names whose directions span the same space, symmetries first; a symmetry counts when its sine to
/// the space is below 1e-6. Throws std::invalid_argument for sizes that do not match.
std::vector<NamedDirection> name_unobservable(const Matrix& unobservable, const BlockLayout& layout,
                                              const Vector& linearisation_point = Vector(),
                                              const Matrix& anchors = Matrix());

/// The listings of the largest components of directions of a state without known symmetries, by the names of
/// its states. Throws std::invalid_argument for names that are not as many as the directions have rows.
std::vector<NamedDirection> name_unobservable(const Matrix& unobservable,
                                              const std::vector<std::string>& states);

/// The names of the states: r, f1, f2 … in one dimension; x, y, heading, f1x, f1y … in the plane; x1 … else.
std::vector<std::string> state_names(const BlockLayout& layout);

}  // namespace credence::internal
