#include "datasets/logs/autopilot/ulog.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/data_error.h"
#include "datasets/logs/autopilot/ulog_innovations.h"
#include "tests/datasets/data_folder.h"
#include "tests/datasets/logs/autopilot/ulog_writer.h"
#include "tests/datasets/logs/byte_writer.h"
#include "tests/datasets/logs/hostile.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using testing::ByteWriter;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RecordedSink;
using testing::UlogWriter;

/// Two sensors, gps of two components and heading.
UlogWriter with_innovations() {
  UlogWriter log;
  for (const char* name : {"estimator_innovations", "estimator_innovation_variances"}) {
    log.format(
        fmt::format("{}:uint64_t timestamp;uint64_t timestamp_sample;float[2] gps_hpos;float heading;"
                    "float flow;uint8_t[4] _padding0;",
                    name));
  }
  log.subscribe(1, 0, "estimator_innovations");
  log.subscribe(2, 0, "estimator_innovation_variances");
  return log;
}

/// A row of either topic; what is padding at its end is not in the file.
std::string row(std::uint64_t sample, float north, float east, float heading) {
  return ByteWriter().add(sample + 7).add(sample).add(north).add(east).add(heading).add(0.0F).bytes();
}

RecordedSink read(const std::string& bytes, const LogReadOptions& options = {}) {
  const TemporaryFolder folder;
  RecordedSink sink;
  ulog_format().read(folder.write("flight.ulg", bytes), {options, {}, {}}, sink);
  return sink;
}

/// 40 rows at 100 Hz: a new heading in every second row, a new position in every fourth.
UlogWriter flight() {
  UlogWriter log = with_innovations();
  for (int i = 0; i < 40; ++i) {
    const auto time = static_cast<std::uint64_t>(1'000'000 + 10'000 * i);
    const auto gps = static_cast<float>(i / 4 + 1), heading = static_cast<float>(i / 2 + 1);
    log.data(1, row(time, gps, -gps, 0.5F * heading));
    log.data(2, row(time, 4.0F, 9.0F, 0.25F));
  }
  return log;
}

TEST(Ulog, InnovationsAndVariancesAreJoinedAndRepeatsAreNoNewInnovations) {
  const RecordedSink sink = read(flight().bytes());
  ASSERT_EQ(sink.runs.size(), 1U);
  const RecordedSink::Run& run = sink.runs.front();
  EXPECT_FALSE(run.layout.has_truth);
  ASSERT_EQ(run.layout.sensors.size(), 2U);  // flow has no variance: it is not in use
  EXPECT_EQ(run.layout.sensors[0].name, "gps_hpos");
  EXPECT_EQ(run.layout.sensors[0].dim, 2);
  EXPECT_EQ(run.layout.sensors[1].name, "heading");
  EXPECT_EQ(run.layout.sensors[1].angles, std::vector<bool>{true});
  ASSERT_EQ(run.steps.size(), 20U);
  // Step k holds the k-th value of each sensor.
  for (int k = 0; k < 20; ++k) {
    const Step& step = run.steps[static_cast<std::size_t>(k)];
    EXPECT_EQ(step.step, k + 1);
    EXPECT_EQ(step.innovations[1].nu, Vector::Constant(1, 0.5 * (k + 1)));
    EXPECT_EQ(step.innovations[1].S, Matrix::Constant(1, 1, 0.25));
    if (k >= 10) {
      EXPECT_EQ(step.innovations[0].nu.size(), 0);
      continue;
    }
    EXPECT_EQ(step.innovations[0].nu, Eigen::Vector2d(k + 1, -k - 1));
    EXPECT_EQ(step.innovations[0].S, Eigen::Vector2d(4.0, 9.0).asDiagonal().toDenseMatrix());
  }
  EXPECT_THAT(sink.said(), HasSubstr("40 rows of estimator_innovations at 100 Hz"));
  EXPECT_THAT(sink.said(), HasSubstr("10 of gps_hpos (25 Hz), 20 of heading (50 Hz)"));
  EXPECT_THAT(sink.said(), HasSubstr("variances and no covariances"));
  EXPECT_THAT(sink.said(), Not(HasSubstr("side by side")));
}

TEST(Ulog, AnInnovationWithAnotherVarianceIsStillARepeat) {
  UlogWriter log = with_innovations();
  for (int i = 0; i < 6; ++i) {
    const auto time = static_cast<std::uint64_t>(1000 * (i + 1));
    log.data(1, row(time, 0.0F, 0.0F, static_cast<float>(i / 3)));
    log.data(2, row(time, 0.0F, 0.0F, 1.0F + static_cast<float>(i)));
  }
  const RecordedSink sink = read(log.bytes());
  ASSERT_EQ(sink.runs.front().layout.sensors.size(), 1U);
  ASSERT_EQ(sink.runs.front().steps.size(), 2U);
  EXPECT_EQ(sink.runs.front().steps[1].innovations[0].S(0, 0), 4.0);  // of the row in which it was new
}

TEST(Ulog, ALogThatRepeatsNothingMayLeaveValuesOut) {
  UlogWriter log = with_innovations();
  for (int i = 0; i < 30; ++i) {  // 2 Hz, as on hardware
    const auto time = static_cast<std::uint64_t>(500'000 * (i + 1));
    log.data(2, row(time, 1.0F, 1.0F, 1.0F));  // the variances may come first
    log.data(1, row(time, static_cast<float>(i), 0.0F, static_cast<float>(i % 3)));
  }
  const RecordedSink sink = read(log.bytes());
  EXPECT_EQ(sink.runs.front().steps.size(), 30U);
  EXPECT_THAT(sink.said(), HasSubstr("No value of gps_hpos, heading is repeated"));
}

TEST(Ulog, OneOfSeveralEstimatorsIsJudged) {
  UlogWriter log = flight();
  log.subscribe(3, 1, "estimator_innovations");
  log.subscribe(4, 1, "estimator_innovation_variances");
  for (int i = 0; i < 3; ++i) {
    const auto time = static_cast<std::uint64_t>(1000 * (i + 1));
    log.data(3, row(time, 0.0F, 0.0F, 7.0F + static_cast<float>(i)));
    log.data(4, row(time, 0.0F, 0.0F, 1.0F));
  }
  const RecordedSink first = read(log.bytes());
  EXPECT_EQ(first.runs.front().steps.size(), 20U);
  EXPECT_THAT(first.said(), HasSubstr("Estimators 0, 1 ran side by side; judged is 0"));
  const RecordedSink second = read(log.bytes(), {.instance = 1});
  ASSERT_EQ(second.runs.front().steps.size(), 3U);
  EXPECT_EQ(second.runs.front().steps[0].innovations[0].nu[0], 7.0);
  EXPECT_THAT([&] { read(log.bytes(), {.instance = 5}); },
              ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("--instance 5: there are 0, 1")));
}

TEST(Ulog, TopicsOfSingleSensorsAreTakenBeforeThatOfAll) {
  UlogWriter log = flight();
  log.format(
      "estimator_aid_src_baro_hgt:uint64_t timestamp;uint64_t timestamp_sample;uint8_t "
      "estimator_instance;float innovation;float innovation_variance;bool innovation_rejected;");
  log.subscribe(9, 3, "estimator_aid_src_baro_hgt");
  for (int i = 0; i < 6; ++i) {
    log.data(9, ByteWriter()
                    .add<std::uint64_t>(5)
                    .add(static_cast<std::uint64_t>(100 * (i / 2)))
                    .add<std::uint8_t>(0)
                    .add(static_cast<float>(i / 2))
                    .add(2.0F)
                    .add(static_cast<std::uint8_t>(i < 2))
                    .bytes());
  }
  const RecordedSink sink = read(log.bytes());
  ASSERT_EQ(sink.runs.front().layout.sensors.size(), 1U);
  EXPECT_EQ(sink.runs.front().layout.sensors[0].name, "baro_hgt");
  EXPECT_EQ(sink.runs.front().steps.size(), 3U);
  EXPECT_THAT(sink.said(), HasSubstr("1 of these innovations did not pass the filter's gate"));
}

TEST(Ulog, TestRatiosAloneGiveNis) {
  UlogWriter log;
  const std::string key = "float EKF2_BARO_GATE";
  log.message('P', ByteWriter().add(static_cast<std::uint8_t>(key.size())).text(key).add(4.0F).bytes());
  log.format(
      "estimator_innovation_test_ratios:uint64_t timestamp;uint64_t timestamp_sample;float[2] gps_hpos;float "
      "baro_vpos;float heading;float[3] mag_field;float airspeed;");
  log.subscribe(1, 0, "estimator_innovation_test_ratios");
  for (int i = 0; i < 40; ++i) {
    const auto time = static_cast<std::uint64_t>(10'000 * i);
    const auto ratio = static_cast<float>(1 + i / 2);  // every one is said twice
    ByteWriter row;
    row.add(time).add(time).add(0.5F).add(0.0F).add(0.25F * ratio).add(ratio);
    log.data(1, row.add(ratio).add(2.0F * ratio).add(3.0F * ratio).add(0.0F).bytes());
  }
  const RecordedSink sink = read(log.bytes());
  const RecordedSink::Run& run = sink.runs.at(0);
  std::vector<std::string> names;
  for (const Sensor& sensor : run.layout.sensors) {
    EXPECT_TRUE(sensor.nis_alone);
    names.push_back(sensor.name);
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"baro_vpos", "heading", "mag_field.1", "mag_field.2", "mag_field.3"}));
  ASSERT_EQ(run.steps.size(), 20U);
  const auto nis = [&](std::size_t k, std::size_t sensor) { return run.steps[k].innovations[sensor].nu[0]; };
  EXPECT_NEAR(nis(2, 0), 0.25 * 3.0 * 4.0 * 4.0, 1e-5);  // ratio × gate²
  EXPECT_NEAR(nis(2, 1), 3.0 * 2.6 * 2.6, 1e-5);
  EXPECT_NEAR(nis(2, 4), 9.0 * 3.0 * 3.0, 1e-5);
  EXPECT_THAT(sink.said(),
              HasSubstr("40 rows of estimator_innovation_test_ratios and no innovation variances"));
  EXPECT_THAT(sink.said(), HasSubstr("does not hold the gates EKF2_HDG_GATE 2.6, EKF2_MAG_GATE 3"));
  EXPECT_THAT(sink.said(), HasSubstr("which is no NIS"));
}

TEST(Ulog, InnovationsWithVariancesAreTakenBeforeTestRatios) {
  UlogWriter log = flight();
  log.format("estimator_innovation_test_ratios:uint64_t timestamp;float heading;");
  log.subscribe(9, 0, "estimator_innovation_test_ratios");
  for (int i = 0; i < 9; ++i) {
    log.data(9, ByteWriter().add<std::uint64_t>(5).add(static_cast<float>(i)).bytes());
  }
  const RecordedSink sink = read(log.bytes());
  EXPECT_FALSE(sink.runs.at(0).layout.sensors.at(1).nis_alone);
  EXPECT_EQ(sink.runs.at(0).steps.size(), 20U);
}

TEST(Ulog, DataAppendedAfterACutAreRead) {
  UlogWriter log = with_innovations();
  log.data(1, row(1000, 0.0F, 0.0F, 1.0F));
  log.data(2, row(1000, 0.0F, 0.0F, 1.0F));
  std::string bytes = log.bytes() + "\x50";  // a message that was being written
  const std::uint64_t appended = bytes.size();
  UlogWriter more;
  more.data(1, row(2000, 0.0F, 0.0F, 2.0F));
  more.data(2, row(2000, 0.0F, 0.0F, 1.0F));
  bytes += more.bytes().substr(16 + 3 + 40);
  constexpr std::size_t kFlags = 16 + 3;
  bytes[kFlags + 8] = 1;
  bytes.replace(kFlags + 16, 8, ByteWriter().add(appended).bytes());
  EXPECT_EQ(read(bytes).runs.front().steps.size(), 2U);
}

TEST(Ulog, AnErrorNamesTheByte) {
  const std::string good = flight().bytes();
  const auto fails_with = [](const std::string& bytes, const std::string& message) {
    EXPECT_THAT([&] { read(bytes); }, ::testing::ThrowsMessage<DataError>(HasSubstr(message)));
  };
  fails_with("ULog", "byte 0: the header of a ULog of 16 bytes begins here and the file ends at byte 4");
  fails_with("x" + good, "is no ULog");
  fails_with(good.substr(0, good.size() - 1), "a message of 34 bytes begins here and the file ends at byte");
  UlogWriter unknown;
  unknown.data(77, "");
  fails_with(unknown.bytes(), "data of topic 77 that nobody announced");
  UlogWriter plain;
  plain.subscribe(1, 0, "float");
  fails_with(plain.bytes(), "topic 'float' is no message");
  UlogWriter nested;
  nested.format("a:a inner;");
  nested.subscribe(1, 0, "a");
  fails_with(nested.bytes(), "corrupted");
  UlogWriter huge;
  huge.format("a:float[65000] x;");
  huge.subscribe(1, 0, "a");
  fails_with(huge.bytes(), "beyond 64 KB");
  fails_with(UlogWriter().bytes(), "holds no innovations");
  std::string flagged = good;
  flagged[16 + 3 + 8] = 2;
  fails_with(flagged, "a flag 0x2 that is not known");
}

TEST(Ulog, WhatComesBeforeACutIsReadIfAskedFor) {
  const std::string good = flight().bytes();
  const RecordedSink part = read(good.substr(0, good.size() - 1), {.partial = true});
  EXPECT_EQ(part.runs.at(0).steps.size(), 20U);  // the last row only repeats
  EXPECT_THAT(part.said(), HasSubstr("only a part could be read: "));
  EXPECT_THAT(part.said(), HasSubstr("flight.ulg:byte "));
}

TEST(Ulog, NoCutOrFlippedByteCrashes) {
  UlogWriter log = with_innovations();
  for (int i = 0; i < 4; ++i) {
    log.data(1, row(static_cast<std::uint64_t>(i), 1.0F, 2.0F, static_cast<float>(i)));
    log.data(2, row(static_cast<std::uint64_t>(i), 1.0F, 1.0F, 1.0F));
  }
  // A cut between two messages leaves a whole log: at most one for each message.
  EXPECT_LE(testing::unnoticed_cuts(ulog_format(), log.bytes(), {}), 8U);
}

TEST(Ulog, ASampleFlightHasTheCountsThatAnotherProgramFinds) {
  CREDENCE_DATA_OR_SKIP(data, "logs");
  RecordedSink sink;
  ulog_format().read(data / "px4_innovations.ulg", {}, sink);
  EXPECT_THAT(sink.said(), HasSubstr("1279 rows of estimator_innovations at 125 Hz"));
  const RecordedSink::Run& run = sink.runs.at(0);
  ASSERT_EQ(run.layout.sensors.size(), 3U);
  std::vector<int> counts(3, 0);
  std::vector<double> nis(3, 0.0);
  for (const Step& step : run.steps) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Innovation& innovation = step.innovations[i];
      if (innovation.nu.size() == 0) continue;
      ++counts[i];
      nis[i] += innovation.nu.dot(innovation.S.llt().solve(innovation.nu));
    }
  }
  EXPECT_EQ(counts, (std::vector<int>{49, 187, 173}));  // gps_hpos, baro_vpos, heading
  EXPECT_NEAR(nis[0] / (2.0 * 49.0), 0.0005, 0.0001);   // of each of two components
  EXPECT_NEAR(nis[1] / 187.0, 0.0005, 0.0001);
}

}  // namespace
}  // namespace credence::internal
