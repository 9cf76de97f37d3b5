#pragma once

#include <vector>

#include "datasets/replay/carpark.h"

namespace credence::internal {

/// Which beams of a laser scan are a reflective beacon, and which of them belong together.
struct BeaconExtraction {
  double min_range_m = 1.0;       ///< exclusive
  double max_range_m = 30.0;      ///< exclusive
  Index max_beam_gap = 3;         ///< beams this far apart may be one beacon, inclusive
  double max_range_step_m = 1.0;  ///< between neighbours of one beacon, exclusive
};

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
std::vector<BeaconObservation> extract_beacons(const CarparkScan& scan,
                                               const BeaconExtraction& settings = {});

}  // namespace credence::internal
