#include "datasets/logs/ros/pose_bag.h"

#include <gmock/gmock.h>

#include "datasets/logs/ros/ros_log.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using testing::RecordedSink;

/// Little endian numbers and texts one after another, by the specifications of MCAP and CDR.
struct PlainBytes {
  std::string_view rest;

  std::uint64_t number(std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t i = size; i-- > 0;) value = 256 * value + static_cast<std::uint8_t>(rest.at(i));
    rest.remove_prefix(size);
    return value;
  }
  std::string_view text(std::size_t size) {
    const std::string_view taken = rest.substr(0, size);
    rest.remove_prefix(size);
    return taken;
  }
  std::string_view sized_text() { return text(number(4)); }
};

struct BagRecord {
  int opcode;
  PlainBytes body;
};

std::vector<BagRecord> records_of_bag(std::string_view bag) {
  const std::string_view magic("\x89MCAP0\r\n", 8);
  EXPECT_TRUE(bag.starts_with(magic));
  EXPECT_TRUE(bag.ends_with(magic));
  PlainBytes bytes{bag.substr(8, bag.size() - 16)};
  std::vector<BagRecord> records;
  while (!bytes.rest.empty()) {
    const int opcode = static_cast<int>(bytes.number(1));
    records.push_back({opcode, {bytes.text(bytes.number(8))}});
  }
  return records;
}

/// A covariance of which no two entries are the same.
PoseCovariance bag_covariance() {
  PoseCovariance P;
  for (Index i = 0; i < 6; ++i) {
    for (Index j = 0; j < 6; ++j) P(i, j) = static_cast<double>(1 + 6 * i + j);
  }
  return P;
}

LoggedPose bag_pose() {
  return {.time_s = 4000.25,
          .estimate = {{1, 2, 3}, Eigen::Quaterniond(0.5, 0.1, 0.7, 0.5)},
          .P = bag_covariance(),
          .truth = {{-4, -5, -6}, Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0)}};
}

TEST(PoseBag, has_the_records_of_the_specification) {
  const LoggedPose poses[] = {bag_pose(), bag_pose(), bag_pose()};
  const std::string bag = pose_bag_bytes(poses);
  std::vector<int> opcodes;
  for (BagRecord& record : records_of_bag(bag)) {
    opcodes.push_back(record.opcode);
    if (record.opcode == 0x01) {
      EXPECT_EQ(record.body.sized_text(), "ros2");
      EXPECT_EQ(record.body.sized_text(), "credence");
      EXPECT_TRUE(record.body.rest.empty());
    }
    if (record.opcode == 0x02) {
      EXPECT_EQ(record.body.text(16), std::string(16, '\0')) << "no summary";
      EXPECT_EQ(record.body.number(4), 1875167664U) << "as in the conformance tests of MCAP";
    }
  }
  EXPECT_EQ(opcodes, (std::vector<int>{1, 3, 4, 3, 4, 5, 5, 5, 5, 5, 5, 0x0f, 2}));
}

TEST(PoseBag, topics_have_their_schemas) {
  const std::string bag = pose_bag_bytes({});
  std::vector<BagRecord> records = records_of_bag(bag);
  ASSERT_EQ(records.size(), 7U) << "a bag of no poses is one";
  const char* const types[] = {"geometry_msgs/msg/PoseWithCovarianceStamped",
                               "geometry_msgs/msg/PoseStamped"};
  const char* const topics[] = {"/estimate", "/truth"};
  for (std::size_t i = 0; i < 2; ++i) {
    PlainBytes schema = records[1 + 2 * i].body, channel = records[2 + 2 * i].body;
    const std::uint64_t id = schema.number(2);
    EXPECT_GT(id, 0U) << "0 is of none";
    EXPECT_EQ(schema.sized_text(), types[i]);
    EXPECT_EQ(schema.sized_text(), "ros2msg");
    const std::string text(schema.sized_text());
    EXPECT_THAT(text, ::testing::StartsWith("std_msgs/Header header\n"));
    EXPECT_THAT(text, HasSubstr(std::string(80, '=') + "\nMSG: geometry_msgs/Quaternion\nfloat64 x\n"));
    EXPECT_EQ(text.find("float64[36] covariance") != std::string::npos, i == 0);
    EXPECT_TRUE(schema.rest.empty());
    EXPECT_EQ(channel.number(2), i + 1);
    EXPECT_EQ(channel.number(2), id);
    EXPECT_EQ(channel.sized_text(), topics[i]);
    EXPECT_EQ(channel.sized_text(), "cdr");
    EXPECT_EQ(channel.number(4), 0U);
    EXPECT_TRUE(channel.rest.empty());
  }
}

TEST(PoseBag, messages_are_plain_cdr) {
  const LoggedPose poses[] = {bag_pose()};
  const std::string bag = pose_bag_bytes(poses);
  const std::vector<BagRecord> records = records_of_bag(bag);
  for (const std::size_t i : {0U, 1U}) {
    PlainBytes body = records.at(5 + i).body;
    EXPECT_EQ(body.number(2), i + 1);
    EXPECT_EQ(body.number(4), 0U);
    EXPECT_EQ(body.number(8), 4'000'250'000'000U);
    EXPECT_EQ(body.number(8), 4'000'250'000'000U);
    EXPECT_EQ(body.text(4), std::string("\0\1\0\0", 4));
    EXPECT_EQ(body.number(4), 4000U);
    EXPECT_EQ(body.number(4), 250'000'000U);
    EXPECT_EQ(body.number(4), 6U);
    EXPECT_EQ(body.text(6), std::string("world\0", 6));
    body.text(6);  // from 18 bytes to a multiple of 8
    std::vector<double> wanted = {1, 2, 3, 0.1, 0.7, 0.5, 0.5};
    if (i == 1) wanted = {-4, -5, -6, 1, 0, 0, 0};
    for (int entry = 1; entry <= 36 && i == 0; ++entry) wanted.push_back(entry);
    for (const double value : wanted) EXPECT_EQ(std::bit_cast<double>(body.number(8)), value);
    EXPECT_TRUE(body.rest.empty());
  }
}

TEST(PoseBag, a_byte_that_is_not_as_written_is_found) {
  const LoggedPose poses[] = {bag_pose(), bag_pose()};
  const std::string bag = pose_bag_bytes(poses);
  const TemporaryFolder folder;
  LogReading options;
  options.truth_topic = kPoseBagTruth;
  const std::size_t end = bag.size() - 8 - 29 - 13;  // of the data: magic, footer and the end's own record
  const auto read = [&](const std::string& bytes) {
    RecordedSink sink;
    mcap_format().read(folder.write("poses.mcap", bytes), options, sink);
  };
  EXPECT_NO_THROW(read(bag));
  for (std::size_t at = 8; at < end; at += 11) {
    std::string flipped = bag;
    flipped[at] = static_cast<char>(flipped[at] ^ 1);
    EXPECT_ANY_THROW(read(flipped)) << "byte " << at;
  }
}

TEST(PoseBag, times_are_rounded_to_a_nanosecond) {
  const auto logged = [](double time_s) {
    LoggedPose pose = bag_pose();
    pose.time_s = time_s;
    const std::string bag = pose_bag_bytes({&pose, 1});
    PlainBytes body = records_of_bag(bag).at(5).body;
    body.text(6);
    const std::uint64_t ns = body.number(8);
    body.text(8 + 4);
    EXPECT_EQ(body.number(4), ns / 1'000'000'000U);
    EXPECT_EQ(body.number(4), ns % 1'000'000'000U);
    return ns;
  };
  EXPECT_EQ(logged(0.0), 0U);
  EXPECT_EQ(logged(0.3), 300'000'000U);
  EXPECT_EQ(logged(1.7e9 + 0.25), 1'700'000'000'250'000'000U);
  EXPECT_EQ(logged(1.9999999996), 2'000'000'000U);
  EXPECT_EQ(logged(2.0000000004), 2'000'000'000U);
}

TEST(PoseBag, what_is_written_is_judged_as_it_was) {
  std::vector<LoggedPose> poses;
  for (int i = 0; i < 5; ++i) {
    LoggedPose pose{.time_s = 10.0 + i, .estimate = {}, .truth = {}};
    pose.estimate.position = {1.0 * i, 0.5, -0.25};
    pose.truth.position = {1.0 * i - 0.125, 0.0, 0.0};
    pose.P = (i + 1.0) * PoseCovariance::Identity();
    pose.P(4, 4) = 0.0;  // not estimated
    poses.push_back(pose);
  }
  const TemporaryFolder folder;
  LogReading options;
  options.truth_topic = kPoseBagTruth;
  RecordedSink sink;
  mcap_format().read(folder.write("poses.mcap", pose_bag_bytes(poses)), options, sink);
  ASSERT_EQ(sink.runs.at(0).steps.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    const Step& step = sink.runs[0].steps[i];
    EXPECT_EQ(step.states, (std::vector<Index>{0, 1, 2, 3, 5}));
    EXPECT_EQ(step.error.head<3>(), Eigen::Vector3d(0.125, 0.5, -0.25));
    EXPECT_EQ(step.P.diagonal(), Vector::Constant(5, static_cast<double>(i) + 1.0));
  }
}

}  // namespace
}  // namespace credence::internal
