#pragma once

#include <cstdint>
#include <vector>

#include "core/types.h"
#include "montecarlo/lanes/planar_lanes_kernel.h"

namespace credence::internal {

/// One number of every run of a batch.
struct alignas(64) Lanes {
  double of[kPlanarLanes] = {};
  double& operator[](int lane) { return of[lane]; }
  double operator[](int lane) const { return of[lane]; }
};
using LaneNumbers = std::vector<Lanes>;

inline double* data(LaneNumbers& numbers) { return numbers.empty() ? nullptr : numbers.data()->of; }
inline const double* data(const LaneNumbers& numbers) {
  return numbers.empty() ? nullptr : numbers.data()->of;
}

using LaneSet = std::uint8_t;  ///< bit i: lane i
inline constexpr LaneSet kAllLanes = 0xff;

inline bool has(LaneSet lanes, int lane) { return ((lanes >> lane) & 1u) != 0; }
inline LaneSet with(LaneSet lanes, int lane) { return static_cast<LaneSet>(lanes | (1u << lane)); }
inline LaneSet without(LaneSet lanes, int lane) { return static_cast<LaneSet>(lanes & ~(1u << lane)); }

}  // namespace credence::internal
