#include "datasets/replay/beacon_extraction.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "core/manifold/angle.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

CarparkScan empty_scan() { return {0, Vector::Constant(361, 81.91), Vector::Zero(361)}; }

void reflect(CarparkScan& scan, Index beam, double range_m) {
  scan.range_m(beam) = range_m;
  scan.intensity(beam) = 1;
}

TEST(BeaconExtraction, AveragesRangeAndBeamOfACluster) {
  CarparkScan scan = empty_scan();
  reflect(scan, 180, 10.0);
  reflect(scan, 181, 10.2);
  reflect(scan, 184, 10.4);  // three beams on: still a neighbour
  const auto seen = extract_beacons(scan);
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_DOUBLE_EQ(seen[0].range_m, 10.2);
  EXPECT_DOUBLE_EQ(seen[0].bearing_rad, (545.0 / 3.0 * 0.5 - 90.0) * kRadiansPerDegree);
}

TEST(BeaconExtraction, SplitsAtGapsAndAtSteps) {
  CarparkScan scan = empty_scan();
  reflect(scan, 0, 5.0);  // −90°
  reflect(scan, 4, 5.0);  // four beams on
  reflect(scan, 5, 6.0);  // a metre farther
  const auto seen = extract_beacons(scan);
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_DOUBLE_EQ(seen[0].bearing_rad, -90 * kRadiansPerDegree);
  EXPECT_DOUBLE_EQ(seen[2].range_m, 6.0);
}

TEST(BeaconExtraction, TakesOnlyReflectionsWithinTheLimits) {
  CarparkScan scan = empty_scan();
  reflect(scan, 10, 1.0);
  reflect(scan, 20, 30.0);
  scan.range_m(30) = 10.0;  // no reflection
  EXPECT_TRUE(extract_beacons(scan).empty());
  reflect(scan, 360, 29.99);
  ASSERT_EQ(extract_beacons(scan).size(), 1U);
  EXPECT_DOUBLE_EQ(extract_beacons(scan)[0].bearing_rad, 90 * kRadiansPerDegree);
  scan.intensity.conservativeResize(360);
  EXPECT_THROW(extract_beacons(scan), std::invalid_argument);
}

// docs/datasets.md: 888 observations in 505 of 586 scans, at most 4 in a scan.
TEST(BeaconExtraction, CountsOfTheCarPark) {
  CREDENCE_DATA_OR_SKIP(folder, "carpark");
  const CarparkLog log = read_carpark(folder);
  std::size_t observations = 0, scans = 0, most = 0;
  for (const CarparkScan& scan : log.scans) {
    const std::size_t seen = extract_beacons(scan).size();
    observations += seen;
    scans += seen > 0 ? 1 : 0;
    most = std::max(most, seen);
  }
  EXPECT_EQ(log.scans.size(), 586U);
  EXPECT_EQ(observations, 888U);
  EXPECT_EQ(scans, 505U);
  EXPECT_EQ(most, 4U);
}

}  // namespace
}  // namespace credence::internal
