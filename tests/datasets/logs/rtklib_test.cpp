#include "datasets/logs/rtklib.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <numbers>

#include "datasets/data_error.h"
#include "datasets/logs/geodesy.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using testing::RecordedSink;

constexpr double kDegree = std::numbers::pi / 180.0;
const std::string kGeodetic =
    "% program   : RTKLIB ver.2.4.2\n"
    "%  GPST                  latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)  "
    "sdne(m)  "
    "sdeu(m)  sdun(m) age(s)  ratio\n";
const std::string kPoint =
    kGeodetic +
    "2012/06/10 00:00:00.000   35.000000000  139.000000000   100.0000   1   9   0 0 0 0 0 0   "
    "0.00    0.0\n";

struct RtklibFiles : ::testing::Test {
  RecordedSink read(const std::string& log, const std::string& truth, LogReading options = {}) const {
    const auto file = folder.write("log.pos", log);
    options.truth = TruthFiles(std::vector{file}, {folder.write("truth.pos", truth).string()});
    RecordedSink sink;
    rtklib_format().read(file, options, sink);
    return sink;
  }
  TemporaryFolder folder;
};

/// A place so many metres east, north and up of the survey point.
Eigen::Vector3d place(const Eigen::Vector3d& enu) {
  const Eigen::Vector3d point(35.0 * kDegree, 139.0 * kDegree, 100.0);
  return earth_fixed(point) + east_north_up(point).transpose() * enu;
}

std::string geodetic_row(const std::string& time, const Eigen::Vector3d& enu, const std::string& rest) {
  const Eigen::Vector3d at = geodetic(place(enu));
  return fmt::format("{} {:.12f} {:.12f} {:.7f} {} 0.00 0.0\n", time, at.x() / kDegree, at.y() / kDegree,
                     at.z(), rest);
}

TEST_F(RtklibFiles, ErrorsAreEastNorthUpAndCovariancesComeFromTheirSignedRoots) {
  const RecordedSink sink =
      read(kGeodetic + geodetic_row("2012/06/10 00:00:01.000", {1, 2, 3}, "1 9 0.3 0.2 0.5 -0.1 0.15 -0.2") +
               geodetic_row("2012/06/10 00:00:02.000", {-1, 0, 4}, "5 9 3 2 5 0 0 0") +
               geodetic_row("2012/06/10 00:00:03.000", {0, 0, 1}, "1 9 0.3 0.2 0.5 0 0 0"),
           kPoint);
  ASSERT_EQ(sink.runs.size(), 1U);
  const RecordedSink::Run& run = sink.runs[0];
  EXPECT_EQ(run.layout.states, (std::vector<std::string>{"fix.east", "fix.north", "fix.up", "single.east",
                                                         "single.north", "single.up"}));
  EXPECT_EQ(run.layout.units, std::vector<std::string>(6, "m"));
  ASSERT_EQ(run.layout.blocks.size(), 2U);
  ASSERT_EQ(run.steps.size(), 3U);
  EXPECT_EQ(run.steps[0].states, (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(run.steps[1].states, (std::vector<Index>{3, 4, 5}));
  EXPECT_LT((run.steps[0].error - Eigen::Vector3d(1, 2, 3)).norm(), 1e-4);
  EXPECT_LT((run.steps[1].error - Eigen::Vector3d(-1, 0, 4)).norm(), 1e-4);
  Matrix P(3, 3);  // east, north, up; ne = −0.1², eu = 0.15², un = −0.2²
  P << 0.04, -0.01, 0.0225, -0.01, 0.09, -0.04, 0.0225, -0.04, 0.25;
  EXPECT_LT((run.steps[0].P - P).norm(), 1e-12);
  EXPECT_EQ(run.steps[0].line, 3);
}

TEST_F(RtklibFiles, EarthFixedCoordinatesAreTurnedToEastNorthUp) {
  const std::string header =
      "%  GPST          x-ecef(m)      y-ecef(m)      z-ecef(m)   Q  ns   sdx(m)   sdy(m)   sdz(m)  sdxy(m)  "
      "sdyz(m)  "
      "sdzx(m)\n";
  const Eigen::Vector3d at = place({1, 2, 3});
  const RecordedSink sink = read(
      header + fmt::format("1692 1.000 {:.6f} {:.6f} {:.6f} 2 9 2 2 2 0 0 0 0 0\n", at.x(), at.y(), at.z()),
      kPoint);
  EXPECT_EQ(sink.runs[0].layout.states[0], "float.east");
  EXPECT_LT((sink.runs[0].steps[0].error - Eigen::Vector3d(1, 2, 3)).norm(), 1e-4);
  EXPECT_LT((sink.runs[0].steps[0].P - 4.0 * Matrix::Identity(3, 3)).norm(), 1e-12);
}

TEST_F(RtklibFiles, ABetterSolutionIsMatchedInTimeAndItsCovarianceAdded) {
  const std::string rest = " 1 9 1 1 1 0 0 0";
  const std::string log =
      kGeodetic + geodetic_row("1692 10.00", {1, 0, 0}, rest) + geodetic_row("1692 11.00", {2, 0, 0}, rest);
  const std::string truth =
      kGeodetic + geodetic_row("1692 9.00", {9, 9, 9}, rest) + geodetic_row("1692 11.00", {0, 0, 0}, rest);
  const RecordedSink sink = read(log, truth);
  ASSERT_EQ(sink.runs[0].steps.size(), 1U);
  EXPECT_EQ(sink.unmatched_rows, 1);
  EXPECT_NEAR(sink.runs[0].steps[0].error[0], 2.0, 1e-4);
  EXPECT_NEAR(sink.runs[0].steps[0].P(0, 0), 2.0, 1e-12);
  EXPECT_THAT(sink.said(), HasSubstr("the truth has a covariance of its own"));
}

// At 30 m/s, and the truth 10 ms before and 30 ms behind: a quarter of the way, or the nearest, 0.3 m off.
TEST_F(RtklibFiles, BetweenItsTimesTheTruthIsInterpolatedOrTheNearestIsTaken) {
  const std::string rest = " 1 9 1 1 1 0 0 0";
  const std::string log = kGeodetic + geodetic_row("1692 10.01", {0.3, 0, 0}, rest);
  const std::string truth = kGeodetic + geodetic_row("1692 10.00", {0, 0, 0}, " 1 9 1 1 1 0 0 0") +
                            geodetic_row("1692 10.04", {1.2, 0, 0}, " 1 9 3 3 3 0 0 0");
  LogReading reading;
  reading.matching.max_time_difference_s = 0.035;
  const Step between = read(log, truth, reading).runs[0].steps.at(0);
  EXPECT_NEAR(between.error[0], 0.0, 1e-4);
  EXPECT_NEAR(between.P(0, 0), 1.0 + 0.75 * 1.0 + 0.25 * 9.0, 1e-9);
  reading.matching.truth_time = TruthTime::nearest;
  EXPECT_NEAR(read(log, truth, reading).runs[0].steps.at(0).error[0], 0.3, 1e-4);
  EXPECT_THAT([&] { read(log, truth); },
              ::testing::ThrowsMessage<DataError>(HasSubstr(
                  "estimates from 1692 10.010 to 1692 10.010, truth from 1692 10.000 to 1692 10.040 "
                  "(week and seconds), within 0.02 s (--max-time-difference, --truth-time nearest)")));
}

TEST_F(RtklibFiles, TimesOfTwoSystemsAreRefused) {
  const std::string rest = " 1 9 1 1 1 0 0 0";
  const auto rows = [&](const std::string& system) {
    std::string header = kGeodetic;
    header.replace(header.find("GPST"), 4, system);
    return header + geodetic_row("1692 10.00", {1, 0, 0}, rest) + geodetic_row("1692 11.00", {1, 0, 0}, rest);
  };
  EXPECT_EQ(read(rows("UTC"), rows("UTC")).runs[0].steps.size(), 2U);
  EXPECT_THAT([&] { read(rows("GPST"), rows("UTC")); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("its times are UTC and those of ")));
}

TEST_F(RtklibFiles, TellsHowFarATruthThatMovesHasTravelled) {
  const std::string rest = " 1 9 1 1 1 0 0 0";
  const std::string rows =
      kGeodetic + geodetic_row("1692 10.00", {1, 0, 0}, rest) + geodetic_row("1692 11.00", {4, 4, 0}, rest);
  const RecordedSink moving = read(rows, rows);
  ASSERT_EQ(moving.runs[0].travelled_m.size(), 2U);
  EXPECT_NEAR(moving.runs[0].travelled_m[1], 5.0, 1e-3);
  EXPECT_TRUE(
      read(rows, kGeodetic + geodetic_row("1692 10.00", {1, 0, 0}, rest)).runs[0].travelled_m.empty());
}

TEST_F(RtklibFiles, CalendarAndWeekAreTheSameTime) {
  // GPS week 1692 began on 2012-06-10.
  const auto week =
      read_rtklib(folder.write("a.pos", kGeodetic + geodetic_row("1692 90.5", {0, 0, 0}, "1 9 1 1 1 0 0 0")));
  const auto day = read_rtklib(folder.write(
      "b.pos", kGeodetic + geodetic_row("2012/06/10 00:01:30.500", {0, 0, 0}, "1 9 1 1 1 0 0 0")));
  EXPECT_EQ(week.fixes[0].time_s, day.fixes[0].time_s);
}

TEST_F(RtklibFiles, ErrorsNameTheLine) {
  const auto fails_with = [&](const std::string& log, const std::string& message) {
    EXPECT_THAT([&] { read(log, kPoint); }, ::testing::ThrowsMessage<DataError>(HasSubstr(message)));
  };
  const std::string row = geodetic_row("1692 1.0", {0, 0, 0}, "1 9 1 1 1 0 0 0");
  fails_with(row, "names the columns before the first row");
  fails_with(kGeodetic, "holds no solutions");
  fails_with(kGeodetic + row + row, "log.pos:4: the time does not increase");
  fails_with(kGeodetic + "1692 1.0 35 139 100 1 9 1 1\n", "log.pos:3: 9 fields where at least 13");
  fails_with(kGeodetic + "1692 1.0 35 139 x 1 9 1 1 1 0 0 0\n", "log.pos:3: 'x' is not a finite number");
  fails_with(kGeodetic + "1692 1.0 35 139 1 9 9 1 1 1 0 0 0\n", "Q = 9: accepted are 0 to 6");
  fails_with(kGeodetic + "2012/13/10 00:00:00.0 35 139 1 1 9 1 1 1 0 0 0\n", "is no day");
  fails_with(kGeodetic + "1e99/13/10 00:00:00.0 35 139 1 1 9 1 1 1 0 0 0\n", "is no whole number of a date");
  fails_with(kGeodetic + row.substr(0, row.size() - 1), "the last line has no end");
  fails_with("%  GPST  latitude(d'\")\n", "degrees, minutes and seconds are not read");
}

}  // namespace
}  // namespace credence::internal
