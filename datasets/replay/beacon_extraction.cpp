#include "datasets/replay/beacon_extraction.h"

#include <cmath>
#include <stdexcept>

#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

constexpr double kDegreesPerBeam = 0.5;
constexpr double kFirstBeamDeg = -90.0;
constexpr double kNearestBeaconM = 1.0, kFarthestBeaconM = 30.0;  // exclusive
constexpr Index kBeamGap = 3;         // beams this far apart may be one beacon, inclusive
constexpr double kBeaconStepM = 1.0;  // between neighbours of one beacon, exclusive

BeaconObservation mean_of(const std::vector<Index>& beams, const Vector& range_m) {
  double range = 0, beam = 0;
  for (const Index k : beams) {
    range += range_m(k);
    beam += static_cast<double>(k);
  }
  const auto count = static_cast<double>(beams.size());
  const double bearing_deg = kFirstBeamDeg + kDegreesPerBeam * beam / count;
  return {range / count, bearing_deg * kRadiansPerDegree};
}

}  // namespace

std::vector<BeaconObservation> extract_beacons(const CarparkScan& scan) {
  if (scan.range_m.size() != scan.intensity.size())
    throw std::invalid_argument("a laser scan has as many intensities as ranges");
  std::vector<BeaconObservation> observations;
  std::vector<Index> cluster;
  for (Index k = 0; k < scan.range_m.size(); ++k) {
    const double range = scan.range_m(k);
    if (scan.intensity(k) <= 0 || range <= kNearestBeaconM || range >= kFarthestBeaconM) continue;
    const bool joins = !cluster.empty() && k - cluster.back() <= kBeamGap &&
                       std::abs(range - scan.range_m(cluster.back())) < kBeaconStepM;
    if (!joins && !cluster.empty()) {
      observations.push_back(mean_of(cluster, scan.range_m));
      cluster.clear();
    }
    cluster.push_back(k);
  }
  if (!cluster.empty()) observations.push_back(mean_of(cluster, scan.range_m));
  return observations;
}

}  // namespace credence::internal
