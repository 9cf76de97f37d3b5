#pragma once

#include <vector>

#include "datasets/replay/carpark.h"
#include "datasets/replay/replay_filter.h"

namespace credence::internal {

/// What was seen in one scan, each observation with its surveyed beacon, and where the vehicle was.
struct ScanObservations {
  std::vector<LoggedObservation> observations;
  std::vector<double> distance_m;  ///< from the beacon that the observation was given, or that is nearest
  Pose localised = Pose::Zero();   ///< by the survey, after this scan
};

/// Throws DataError unless half of all observations or more have a surveyed beacon: swapped columns, another
/// survey.
void check_association(const std::vector<ScanObservations>& scans);

/// The beacons in the order of first observation.
std::vector<int> beacons_by_first_observation(const std::vector<ScanObservations>& scans);

/// Where the vehicle starts: at the first GPS fix, with the heading of the settings.
Pose carpark_start(const CarparkLog& log, double heading_rad);

/// The known association: each observation belongs to the surveyed beacon nearest to where it points, if that
/// lies within `max_distance_m`; else to none (landmark −1).
///
/// Where it points is told by the GPS position at the time of the scan and by the heading of a localisation
/// on the survey, ACFR's tuning: so it is independent of the filter that is judged. One entry for each scan.
std::vector<ScanObservations> associate_by_survey(const CarparkLog& log, double heading_rad,
                                                  double max_distance_m = 2.0);

}  // namespace credence::internal
