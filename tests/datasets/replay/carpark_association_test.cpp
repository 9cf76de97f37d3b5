#include "datasets/replay/carpark_association.h"

#include <gmock/gmock.h>

#include <numbers>
#include <utility>

#include "datasets/data_error.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// A vehicle that drives east along the x axis at 1 m/s by its GPS, its odometry silent, and looks around
/// once, after 4 s. Beam 180 looks ahead, beam 360 to the left, beam 0 to the right.
CarparkLog one_look() {
  CarparkLog log;
  log.gps = {{0.0, {0.0, 0.0}}, {10.0, {10.0, 0.0}}};
  log.odometry = {{0.0, 0.0, 0.0}};
  CarparkScan scan{4.0, Vector::Constant(361, 81.91), Vector::Zero(361)};
  for (const auto& [beam, range_m] : {std::pair<Index, double>{180, 10.0}, std::pair<Index, double>{360, 5.0},
                                      std::pair<Index, double>{0, 5.0}}) {
    scan.range_m(beam) = range_m;
    scan.intensity(beam) = 1.0;
  }
  log.scans = {scan};
  log.events = {{0.0, CarparkSensor::gps, 0},
                {0.0, CarparkSensor::odometry, 0},
                {4.0, CarparkSensor::laser, 0},
                {10.0, CarparkSensor::gps, 1}};
  log.beacons_m = {{4.0, -8.0}, {14.0, 0.0}, {4.0, 6.5}, {100.0, 100.0}};
  return log;
}

TEST(CarparkAssociation, AnObservationIsOfTheNearestBeaconWithinReachOfWhereItPoints) {
  const std::vector<ScanObservations> scans = associate_by_survey(one_look(), 0.0, 2.0);
  ASSERT_EQ(scans.size(), 1U);
  ASSERT_EQ(scans[0].observations.size(), 3U);
  // Right to left: (4, −5) is 3 m from its beacon, (14, 0) on it, (4, 5) 1.5 m from it.
  EXPECT_EQ(scans[0].observations[0].landmark, -1);
  EXPECT_EQ(scans[0].observations[1].landmark, 1);
  EXPECT_EQ(scans[0].observations[2].landmark, 2);
  EXPECT_NEAR(scans[0].distance_m[0], 3.0, 1e-9) << "the nearest, though it is none";
  EXPECT_NEAR(scans[0].distance_m[1], 0.0, 1e-9);
  EXPECT_NEAR(scans[0].distance_m[2], 1.5, 1e-9);
  EXPECT_EQ(associate_by_survey(one_look(), 0.0, 3.5)[0].observations[0].landmark, 0);
  EXPECT_EQ(associate_by_survey(one_look(), 0.0, 1.0)[0].observations[2].landmark, -1);
}

TEST(CarparkAssociation, TheHeadingTurnsWhereTheObservationsPoint) {
  // Facing north the beam ahead points at (4, 10), and the one to the right, 5 m, at (9, 0): 5 m from (14,
  // 0).
  const std::vector<ScanObservations> scans = associate_by_survey(one_look(), 0.5 * std::numbers::pi, 100.0);
  EXPECT_EQ(scans[0].observations[0].landmark, 1);
  EXPECT_NEAR(scans[0].distance_m[0], 5.0, 1e-9);
  EXPECT_EQ(scans[0].observations[1].landmark, 2);
  EXPECT_NEAR(scans[0].distance_m[1], 3.5, 1e-9);
}

TEST(CarparkAssociation, ThePositionIsHeldBeforeTheFirstFixAndBehindTheLast) {
  CarparkLog log = one_look();
  log.gps = {{20.0, {4.0, 0.0}}, {30.0, {50.0, 0.0}}};
  EXPECT_NEAR(associate_by_survey(log, 0.0)[0].distance_m[1], 0.0, 1e-9);
  log.gps = {{-20.0, {50.0, 0.0}}, {-10.0, {4.0, 0.0}}};
  EXPECT_NEAR(associate_by_survey(log, 0.0)[0].distance_m[1], 0.0, 1e-9);
}

TEST(CarparkAssociation, TheVehicleStartsAtTheFirstFixWithItsHeadingWrapped) {
  CarparkLog log;
  log.gps = {{1.0, {2.0, 3.0}}};
  const Pose start = carpark_start(log, 2.5 * std::numbers::pi);
  EXPECT_NEAR((start - Pose(2.0, 3.0, 0.5 * std::numbers::pi)).norm(), 0.0, 1e-12);
}

ScanObservations observations_of(std::initializer_list<int> landmarks) {
  ScanObservations scan;
  for (const int landmark : landmarks) scan.observations.push_back({landmark, RangeBearing(1.0, 0.0)});
  return scan;
}

TEST(CarparkAssociation, BeaconsAreInTheOrderOfTheirFirstObservation) {
  EXPECT_THAT(beacons_by_first_observation(
                  {observations_of({-1, 7}), observations_of({}), observations_of({3, 7, 0})}),
              ElementsAre(7, 3, 0));
}

TEST(CarparkAssociation, HalfOfTheObservationsMustHaveABeacon) {
  EXPECT_NO_THROW(check_association({observations_of({1, -1}), observations_of({-1, 2})}));
  EXPECT_THAT(
      [] {
        check_association({observations_of({1, -1}), observations_of({-1, 2, -1})});
      },
      ThrowsMessage<DataError>(
          HasSubstr("beac_juan3.mat:variable 'estbeac': only 2 of 5 observations point at a "
                    "surveyed beacon")));
  EXPECT_THROW(check_association({}), DataError) << "nothing was seen at all";
}

}  // namespace
}  // namespace credence::internal
