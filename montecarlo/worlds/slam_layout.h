#pragma once

#include <span>

#include "core/record/block_layout.h"
#include "core/record/run_layout.h"

namespace credence::internal {

/// The layout of a SLAM state: a vehicle on a line (dimension 1) or a pose in the plane (3), then the
/// landmarks. `measurements`: the largest dimension of an innovation, which is taken apart into pieces of one
/// landmark each unless it has at most four rows and the same ones at every step (`constant`).
RunLayout slam_layout(const BlockLayout& blocks, Index measurements, bool constant);

/// The states of a step, by number of the layout, that knows these landmarks in this order.
void slam_states(const BlockLayout& blocks, std::span<const int> landmarks, std::vector<Index>& states);

}  // namespace credence::internal
