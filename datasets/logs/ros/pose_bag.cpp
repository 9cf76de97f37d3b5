#include "datasets/logs/ros/pose_bag.h"

#include <fmt/format.h>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "datasets/logs/bytes/append_crc32.h"
#include "datasets/logs/bytes/append_number.h"
#include "datasets/logs/ros/mcap.h"

namespace credence::internal {
namespace {

/// Fields of a message in CDR: each number at a multiple of its size behind the four bytes of encapsulation.
class CdrWriter {
 public:
  template <class T>
  void number(T value) {
    while ((bytes_.size() - kEncapsulation) % sizeof(T) != 0) bytes_ += '\0';
    append_number(bytes_, value);
  }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    bytes_ += text;
    bytes_ += '\0';
  }
  void header(std::int64_t time_ns) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    number(static_cast<std::int32_t>(time_ns / kSecond));
    number(static_cast<std::uint32_t>(time_ns % kSecond));
    text("world");
  }
  void pose(const SpatialPose& pose) {
    for (const double value : pose.position) number(value);
    for (const double value : pose.orientation.coeffs()) number(value);  // x y z w
  }
  const std::string& bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kEncapsulation = 4;
  std::string bytes_{'\0', '\1', '\0', '\0'};  // plain CDR, little endian
};

std::string text(std::string_view text) {
  std::string bytes;
  append_number(bytes, static_cast<std::uint32_t>(text.size()));
  return bytes.append(text);
}

void add_record(std::string& file, std::uint8_t opcode, std::string_view body) {
  append_number(file, opcode);
  append_number(file, static_cast<std::uint64_t>(body.size()));
  file += body;
}

/// A definition of a message followed by those that it names.
std::string schema_text(std::string_view fields, bool covariance) {
  std::string schema(fields);
  const auto define = [&](std::string_view name, std::string_view definition) {
    schema += fmt::format("{:=<80}\nMSG: {}\n{}", "", name, definition);
  };
  define("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n");
  define("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
  if (covariance)
    define("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n");
  define("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n");
  define("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n");
  define("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
  return schema;
}

void add_topic(std::string& file, std::uint16_t id, const char* topic, const char* type,
               const std::string& schema) {
  std::string body;
  append_number(body, id);
  add_record(file, McapOpcode::kSchema, body + text(type) + text("ros2msg") + text(schema));
  append_number(body, id);  // the channel's own number, then that of its schema
  body += text(topic) + text("cdr");
  append_number(body, std::uint32_t{0});  // no metadata
  add_record(file, McapOpcode::kChannel, body);
}

void add_message(std::string& file, std::uint16_t topic, std::uint32_t number, std::int64_t time_ns,
                 const CdrWriter& message) {
  std::string body;
  append_number(body, topic);
  append_number(body, number);
  append_number(body, time_ns);  // logged
  append_number(body, time_ns);  // published
  add_record(file, McapOpcode::kMessage, body + message.bytes());
}

}  // namespace

std::string pose_bag_bytes(std::span<const LoggedPose> poses) {
  constexpr std::uint16_t kEstimateChannel = 1, kTruthChannel = 2;
  std::string file(kMcapMagic);
  add_record(file, McapOpcode::kHeader, text("ros2") + text("credence"));
  add_topic(file, kEstimateChannel, kPoseBagEstimate, "geometry_msgs/msg/PoseWithCovarianceStamped",
            schema_text("std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n", true));
  add_topic(file, kTruthChannel, kPoseBagTruth, "geometry_msgs/msg/PoseStamped",
            schema_text("std_msgs/Header header\ngeometry_msgs/Pose pose\n", false));
  std::uint32_t number = 0;
  for (const LoggedPose& pose : poses) {
    const double whole_s = std::floor(pose.time_s);  // a time since 1970 in ns is beyond 2^53
    const std::int64_t time_ns =
        static_cast<std::int64_t>(whole_s) * 1'000'000'000 + std::llround(1e9 * (pose.time_s - whole_s));
    CdrWriter estimate, truth;
    estimate.header(time_ns);
    estimate.pose(pose.estimate);
    for (Index i = 0; i < 6; ++i) {
      for (Index j = 0; j < 6; ++j) estimate.number(pose.P(i, j));
    }
    truth.header(time_ns);
    truth.pose(pose.truth);
    add_message(file, kEstimateChannel, number, time_ns, estimate);
    add_message(file, kTruthChannel, number++, time_ns, truth);
  }
  std::string checksum;
  append_crc32(checksum, file);
  add_record(file, McapOpcode::kDataEnd, checksum);
  std::string footer;
  add_record(footer, McapOpcode::kFooter, std::string(20, '\0'));  // no summary
  footer.resize(footer.size() - 4);
  append_crc32(footer, footer);
  file += footer;
  return file.append(kMcapMagic);
}

}  // namespace credence::internal
