#include "datasets/replay/beacon_extraction.h"

#include <cmath>
#include <stdexcept>

#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

constexpr double kDegreesPerBeam = 0.5;
constexpr double kFirstBeamDeg = -90.0;

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

std::vector<BeaconObservation> extract_beacons(const CarparkScan& scan, const BeaconExtraction& settings) {
  if (scan.range_m.size() != scan.intensity.size())
    throw std::invalid_argument("a laser scan has as many intensities as ranges");
  std::vector<BeaconObservation> observations;
  std::vector<Index> cluster;
  for (Index k = 0; k < scan.range_m.size(); ++k) {
    const double range = scan.range_m(k);
    if (scan.intensity(k) <= 0 || range <= settings.min_range_m || range >= settings.max_range_m) continue;
    const bool joins = !cluster.empty() && k - cluster.back() <= settings.max_beam_gap &&
                       std::abs(range - scan.range_m(cluster.back())) < settings.max_range_step_m;
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
