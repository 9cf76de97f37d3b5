#include "datasets/logs/autopilot/dataflash_innovations.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/datasets/logs/autopilot/dataflash_writer.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using testing::ByteWriter;
using testing::DataflashWriter;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RecordedSink;

RecordedSink judged_cores(const DataflashWriter& log) {
  const TemporaryFolder folder;
  RecordedSink sink;
  dataflash_format().read(folder.write("flight.bin", log.bytes()), {}, sink);
  return sink;
}

/// Rows of a core in which the height alone speaks, with this root of its test ratio.
void say_height(DataflashWriter& log, int row, double innovation, double root) {
  const auto time = static_cast<std::uint64_t>(1000 * row);
  log.innovations(time, 0, {0, 0, 0, 0, 0, innovation, 0});
  log.ratios(time, 0, {0, 0, root, 0, 0});
}

/// NIS of the only sensor at each step.
std::vector<double> nis_of_heights(const RecordedSink& sink) {
  std::vector<double> nis;
  EXPECT_EQ(sink.runs.at(0).layout.sensors.size(), 1U);
  for (const Step& step : sink.runs.at(0).steps) nis.push_back(step.innovations.at(0).nu.squaredNorm());
  return nis;
}

// Messages 4 and 5: those of EKF2, which have no core and no airspeed.
TEST(DataflashInnovations, Ekf2IsReadWhereThereIsNoEkf3) {
  DataflashWriter log;
  log.describe(4, 3 + 8 + 4, "NKF3", "Qcc", "TimeUS,IPN,IPE");
  log.describe(5, 3 + 8 + 2, "NKF4", "Qc", "TimeUS,SP");
  log.parameter("EK2_POS_I_GATE", 200.0F);
  log.parameter("EK3_POS_I_GATE", 900.0F);
  for (std::uint64_t i = 1; i <= 2; ++i) {
    const auto east = static_cast<std::int16_t>(400 * i);
    log.message(4, ByteWriter().add(i).add<std::int16_t>(300).add(east).bytes());
    log.message(5, ByteWriter().add(i).add<std::int16_t>(50).bytes());
  }
  const RecordedSink sink = judged_cores(log);
  ASSERT_EQ(sink.runs.at(0).layout.sensors.size(), 1U);
  EXPECT_EQ(sink.runs[0].layout.sensors[0].name, "position");
  // NIS = 2 (0.5 · 2)² = 2 in the direction (3, 4) / 5.
  const Eigen::Vector2d expected = std::sqrt(2.0) * Eigen::Vector2d(0.6, 0.8);
  EXPECT_LT((sink.runs[0].steps.at(0).innovations[0].nu - expected).norm(), 1e-12);
  EXPECT_THAT(sink.said(), HasSubstr("2 rows of NKF3 with NKF4"));
  EXPECT_THAT(sink.said(), HasSubstr("EK2_VEL_I_GATE 500, EK2_HGT_I_GATE 500, EK2_EAS_I_GATE 400"));
  for (int i = 1; i <= 3; ++i) say_height(log, i, i, 0.1 * i);
  EXPECT_THAT(judged_cores(log).said(), HasSubstr("3 rows of XKF3 with XKF4")) << "taken before EKF2";
}

TEST(DataflashInnovations, RatiosBelongToTheInnovationsOfTheirTime) {
  DataflashWriter log;
  for (int i = 1; i <= 3; ++i) say_height(log, i, i, 0.1 * i);
  log.innovations(9000, 0, {0, 0, 0, 0, 0, 9.0, 0});
  log.ratios(9001, 0, {0, 0, 0.9, 0, 0});
  log.ratios(9000, 1, {0, 0, 0.9, 0, 0});  // of a core that said nothing before
  const RecordedSink sink = judged_cores(log);
  EXPECT_THAT(sink.said(), HasSubstr("3 rows of XKF3 with XKF4"));
  const std::vector<double> nis = nis_of_heights(sink);
  ASSERT_EQ(nis.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(nis[i], std::pow(0.1 * static_cast<double>(i + 1) * 5.0, 2), 1e-12);
  }
}

// Of one component ν is ±√NIS, the same for rows of one ratio: a repeat is what repeats the innovation, too.
TEST(DataflashInnovations, RowsOfOneRatioAreNoRepeats) {
  DataflashWriter log;
  for (int row = 1; row <= 3; ++row) say_height(log, row, row, 0.5);
  say_height(log, 4, 3.0, 0.5);
  const std::vector<double> nis = nis_of_heights(judged_cores(log));
  ASSERT_EQ(nis.size(), 3U);
  EXPECT_EQ(nis[0], nis[2]);
}

// A root below 0.005 is written as 0. Uniform over that, its root mean square is 0.005/√3; the gate is 5.
TEST(DataflashInnovations, ARatioOfZeroIsWhatWasRoundedToIt) {
  DataflashWriter log;
  say_height(log, 1, 1.0, 0.0);
  say_height(log, 2, -2.0, 0.0);
  say_height(log, 3, 0.0, 0.02);
  const RecordedSink sink = judged_cores(log);
  const std::vector<double> nis = nis_of_heights(sink);
  ASSERT_EQ(nis.size(), 3U);
  EXPECT_NEAR(nis[0], 0.005 * 0.005 / 3.0 * 25.0, 1e-15);
  EXPECT_LT(sink.runs[0].steps[1].innovations[0].nu[0], 0.0) << "with the sign of the innovation";
  EXPECT_NEAR(sink.runs[0].steps[2].innovations[0].nu[0], 0.1, 1e-12) << "an innovation rounded to 0";
}

// ArduPilot itself takes a gate for at least one standard deviation; 700 hundredths are 7.
TEST(DataflashInnovations, AGateIsOfHundredthsAndAtLeastOne) {
  for (const auto& [written, gate] : {std::pair(700.0F, 7.0), std::pair(30.0F, 1.0)}) {
    DataflashWriter log;
    log.parameter("EK3_HGT_I_GATE", written);
    log.parameter("EK3_HGT_DELAY", 60.0F);
    for (int i = 1; i <= 2; ++i) say_height(log, i, i, 0.5 * i);
    const RecordedSink sink = judged_cores(log);
    EXPECT_NEAR(nis_of_heights(sink).at(0), 0.25 * gate * gate, 1e-12);
    EXPECT_THAT(sink.said(), Not(HasSubstr("HGT_I_GATE")));
  }
}

TEST(DataflashInnovations, TheListLeavesOutWhatIsOnlyDescribed) {
  DataflashWriter log;
  for (int i = 1; i <= 3; ++i) say_height(log, 1000 * i, i, 0.5);
  const TemporaryFolder folder;
  const LogContents contents = dataflash_format().list(folder.write("flight.bin", log.bytes()));
  for (const LogTopic& topic : contents.topics) {
    EXPECT_NE(topic.name, "PARM");
    if (topic.name == "XKF3") EXPECT_EQ(topic.type, "13 fields");
    if (topic.name == "XKF3" || topic.name == "XKF4") EXPECT_NEAR(topic.rate_hz, 1.0, 1e-12);
    EXPECT_EQ(topic.covariance, topic.name == "XKF4") << topic.name;
  }
  EXPECT_TRUE(dataflash_format().recognises(log.bytes(), "flight.bin"));
}

}  // namespace
}  // namespace credence::internal
