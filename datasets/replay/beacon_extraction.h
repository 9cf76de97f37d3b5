#pragma once

#include <vector>

#include "datasets/replay/carpark.h"

namespace credence::internal {

/// A beacon as the laser saw it.
struct BeaconObservation {
  double range_m = 0;
  double bearing_rad = 0;  ///< to the vehicle's axis, left positive
};

/// The reflective beacons of one scan, in order of bearing, right to left (docs/datasets.md).
///
/// Beams with intensity and a range within limits are clustered with their neighbours; a beacon's range is
/// the mean range and its bearing the mean beam of a cluster. Precondition: range and intensity of equal
/// length.
std::vector<BeaconObservation> extract_beacons(const CarparkScan& scan);

}  // namespace credence::internal
