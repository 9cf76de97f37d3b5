#include "datasets/logs/autopilot/ulog_innovations.h"

#include <gmock/gmock.h>

#include "datasets/data_error.h"
#include "tests/datasets/logs/autopilot/ulog_writer.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using testing::ByteWriter;
using ::testing::HasSubstr;
using testing::RecordedSink;
using testing::UlogWriter;

RecordedSink judged_flight(const UlogWriter& log) {
  const TemporaryFolder folder;
  RecordedSink sink;
  ulog_format().read(folder.write("flight.ulg", log.bytes()), {}, sink);
  return sink;
}

auto refused_with(const std::string& words) { return ::testing::ThrowsMessage<DataError>(HasSubstr(words)); }

/// Topics 1 and 2, innovations and their variances, of these fields behind a timestamp.
UlogWriter pairs_of(const std::string& innovations, const std::string& variances) {
  UlogWriter log;
  log.format("estimator_innovations:uint64_t timestamp;" + innovations);
  log.format("estimator_innovation_variances:uint64_t timestamp;" + variances);
  log.subscribe(1, 0, "estimator_innovations");
  log.subscribe(2, 0, "estimator_innovation_variances");
  return log;
}

void say(UlogWriter& log, std::uint16_t id, std::uint64_t time_us, const std::vector<float>& values) {
  ByteWriter row;
  row.add(time_us);
  for (const float value : values) row.add(value);
  log.data(id, row.bytes());
}

// A timestamp_sample of 0 is none: the rows then meet by when they were sent.
TEST(UlogInnovations, WithoutATimeOfTheSampleThatOfTheMessageCounts) {
  const std::string times = "uint64_t timestamp_sample;";
  UlogWriter log = pairs_of(times + "float baro_vpos;", times + "float baro_vpos;");
  for (const std::uint64_t time_us : {1000U, 2000U, 3000U}) {
    for (const std::uint16_t id : {std::uint16_t{1}, std::uint16_t{2}}) {
      ByteWriter row;
      log.data(id, row.add(time_us).add(std::uint64_t{0}).add(static_cast<float>(time_us)).bytes());
    }
  }
  EXPECT_EQ(judged_flight(log).runs.at(0).steps.size(), 3U);
}

// Of the fields only the first has a variance of as many components.
TEST(UlogInnovations, AFieldWithoutAVarianceOfItsSizeIsNotJudged) {
  UlogWriter log =
      pairs_of("float baro_vpos;float[2] flow;float drag;", "float flow;float baro_vpos;float[2] hagl;");
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<float>(i + 1);
    say(log, 1, 1000U * static_cast<unsigned>(i), {k, k, k, k});
    say(log, 2, 1000U * static_cast<unsigned>(i), {1.0F, 4.0F * k, 1.0F, 1.0F});
  }
  const RecordedSink sink = judged_flight(log);
  ASSERT_EQ(sink.runs.at(0).layout.sensors.size(), 1U);
  EXPECT_EQ(sink.runs[0].layout.sensors[0].name, "baro_vpos");
  ASSERT_EQ(sink.runs[0].steps.size(), 3U);
  EXPECT_EQ(sink.runs[0].steps[2].innovations[0].nu[0], 3.0);
  EXPECT_EQ(sink.runs[0].steps[2].innovations[0].S(0, 0), 12.0);
}

// Row 1 comes when row 2 has met its variance: what waited before that is given up.
TEST(UlogInnovations, RowsAreJoinedInTheOrderOfTime) {
  UlogWriter log = pairs_of("float hagl;", "float hagl;");
  say(log, 1, 1000, {1.0F});
  say(log, 1, 2000, {2.0F});
  say(log, 2, 2000, {1.0F});
  say(log, 2, 1000, {1.0F});
  say(log, 1, 3000, {3.0F});
  say(log, 2, 3001, {1.0F});  // of another moment
  const RecordedSink sink = judged_flight(log);
  ASSERT_EQ(sink.runs.at(0).steps.size(), 1U);
  EXPECT_EQ(sink.runs[0].steps[0].innovations[0].nu[0], 2.0);
}

TEST(UlogInnovations, ASourceHasItsNameDimensionAndEstimator) {
  UlogWriter log;
  log.format(
      "estimator_aid_src_gnss_yaw:uint64_t timestamp;float estimator_instance;float[2] innovation;"
      "float[2] innovation_variance;");
  log.format("estimator_aid_src_hagl:uint64_t timestamp;float innovation;");  // without its variance
  log.subscribe(1, 0, "estimator_aid_src_gnss_yaw");
  log.subscribe(2, 0, "estimator_aid_src_hagl");
  say(log, 1, 1000, {7.0F, 1.0F, 2.0F, 3.0F, 4.0F});
  say(log, 1, 2000, {7.0F, 1.5F, 2.0F, 3.0F, 4.0F});
  say(log, 2, 2000, {1.0F});
  log.message('O', ByteWriter().add<std::uint16_t>(250).bytes());
  const RecordedSink sink = judged_flight(log);
  ASSERT_EQ(sink.runs.at(0).layout.sensors.size(), 1U);
  EXPECT_EQ(sink.runs[0].layout.sensors[0].name, "gnss_yaw");
  EXPECT_EQ(sink.runs[0].steps.at(1).innovations[0].S, Matrix(Eigen::Vector2d(3.0, 4.0).asDiagonal()));
  EXPECT_THAT(sink.said(), HasSubstr("2 rows of estimator_aid_src_*;"));
  EXPECT_THAT(sink.said(), HasSubstr("1 time nothing could be written, for 0.25 s in all"));
  say(log, 1, 3000, {7.5F, 1.0F, 2.0F, 3.0F, 4.0F});
  EXPECT_THAT([&] { judged_flight(log); }, refused_with("an estimator of number 7.5: corrupted"));
}

TEST(UlogInnovations, ATopicWithoutATimeIsRefused) {
  UlogWriter log;
  log.format("estimator_innovations:float hagl;");
  log.subscribe(1, 0, "estimator_innovations");
  log.data(1, ByteWriter().add(1.0F).bytes());
  EXPECT_THAT([&] { judged_flight(log); }, refused_with("topic estimator_innovations without a timestamp"));
}

// 5 rows over 0.4 s: 4 intervals of 0.1 s.
TEST(UlogInnovations, TheListSaysWhatEveryTopicIsFor) {
  UlogWriter log = pairs_of("float hagl;", "float hagl;");
  log.format("estimator_states:uint64_t timestamp;float x;");
  log.format("battery:uint64_t timestamp;float x;");
  log.subscribe(3, 2, "estimator_states");
  log.subscribe(4, 0, "battery");
  for (unsigned i = 0; i < 5; ++i) say(log, 3, 1'000'000U + 100'000U * i, {0.0F});
  const TemporaryFolder folder;
  const LogContents contents = ulog_format().list(folder.write("flight.ulg", log.bytes()));
  ASSERT_EQ(contents.topics.size(), 4U);
  EXPECT_EQ(contents.topics[0].use, "innovations");
  EXPECT_FALSE(contents.topics[0].covariance);
  EXPECT_TRUE(contents.topics[1].covariance);
  EXPECT_EQ(contents.topics[2].use, "estimate");
  EXPECT_EQ(contents.topics[2].type, "instance 2");
  EXPECT_EQ(contents.topics[2].count, 5);
  EXPECT_NEAR(contents.topics[2].rate_hz, 10.0, 1e-9);
  EXPECT_EQ(contents.topics[3].use, "");
}

}  // namespace
}  // namespace credence::internal
