#include "datasets/logs/ros/ros_messages.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "datasets/data_error.h"
#include "tests/datasets/logs/ros/ros_writers.h"

namespace credence::internal {
namespace {

using testing::ByteWriter;
using ::testing::HasSubstr;
using testing::MessageWriter;
using MessageKind = MessageWriter::Kind;

constexpr MessageKind kMessageKinds[] = {MessageKind::ros1, MessageKind::cdr, MessageKind::cdr_big_endian,
                                         MessageKind::cdr2};

/// The poses of a message of this type.
std::vector<RosPose> poses_in(const std::string& type, MessageKind kind, const std::string& bytes,
                              double log_time_s = 7.0) {
  const ByteOrigin origin{"log.bag", ""};
  const Bytes data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  std::vector<RosPose> poses(3);
  read_ros_poses(*ros_pose_type(type),
                 kind == MessageKind::ros1 ? RosTopic::Encoding::ros1 : RosTopic::Encoding::cdr, log_time_s,
                 ByteCursor(data, origin, 0), poses);
  return poses;
}

RosPose only_pose_in(const std::string& type, MessageKind kind, const std::string& bytes) {
  const std::vector<RosPose> poses = poses_in(type, kind, bytes);
  EXPECT_EQ(poses.size(), 1U);
  return poses.at(0);
}

const SpatialPose kMessagePose{{1.5, -2.25, 1e-3}, Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5)};

PoseCovariance message_covariance() {
  PoseCovariance P;
  for (Index i = 0; i < 6; ++i) {
    for (Index j = 0; j < 6; ++j) P(i, j) = static_cast<double>(10 * i + j);
  }
  return P;
}

void expect_message_pose(const SpatialPose& pose) {
  EXPECT_EQ(pose.position, kMessagePose.position);
  EXPECT_TRUE(pose.orientation.coeffs().isApprox(kMessagePose.orientation.coeffs(), 1e-15));
}

void expect_message_fails(const std::string& type, MessageKind kind, const std::string& bytes,
                          const std::string& problem) {
  EXPECT_THAT([&] { poses_in(type, kind, bytes); }, ::testing::ThrowsMessage<DataError>(HasSubstr(problem)));
}

// Frames of every length put every padding before what follows them.
TEST(RosMessages, poses_are_read_behind_frames_of_every_length_in_every_serialisation) {
  for (const MessageKind kind : kMessageKinds) {
    for (std::size_t length = 0; length < 10; ++length) {
      const std::string frame(length, 'f'), child(length / 2, 'c');
      MessageWriter odometry(kind), pose(kind), point(kind), transform(kind);
      odometry.header(12.5, frame).text(child).pose(kMessagePose).matrix(message_covariance());
      const RosPose from = only_pose_in("nav_msgs/Odometry", kind, odometry.bytes());
      EXPECT_EQ(from.time_s, 12.5);
      EXPECT_EQ(from.frame, frame);
      EXPECT_EQ(from.child_frame, child);
      expect_message_pose(from.pose);
      EXPECT_EQ(from.covariance, message_covariance()) << "row by row";

      pose.header(12.5, frame).pose(kMessagePose);
      const RosPose stamped = only_pose_in("geometry_msgs/PoseStamped", kind, pose.bytes());
      expect_message_pose(stamped.pose);
      EXPECT_EQ(stamped.child_frame, "");
      EXPECT_FALSE(stamped.covariance.has_value());
      const std::string with_covariance = pose.matrix(message_covariance()).bytes();
      EXPECT_EQ(only_pose_in("geometry_msgs/PoseWithCovarianceStamped", kind, with_covariance).covariance,
                message_covariance());

      point.header(12.5, frame).vector({1, 2, 3});
      EXPECT_EQ(only_pose_in("geometry_msgs/PointStamped", kind, point.bytes()).pose.position,
                Eigen::Vector3d(1, 2, 3));

      transform.header(12.5, frame).text(child).pose(kMessagePose);
      const RosPose moved = only_pose_in("geometry_msgs/TransformStamped", kind, transform.bytes());
      expect_message_pose(moved.pose);
      EXPECT_EQ(moved.child_frame, child);
    }
  }
}

TEST(RosMessages, transforms_come_one_after_another) {
  for (const MessageKind kind : kMessageKinds) {
    MessageWriter tf(kind);
    tf.add<std::uint32_t>(2).header(1.0, "map").text("odom").pose(SpatialPose{});
    tf.header(2.0, "odom").text("base").pose(kMessagePose);
    for (const char* type : {"tf2_msgs/TFMessage", "tf/tfMessage"}) {
      const std::vector<RosPose> poses = poses_in(type, kind, tf.bytes());
      ASSERT_EQ(poses.size(), 2U);
      EXPECT_EQ(poses[0].child_frame, "odom");
      EXPECT_EQ(poses[1].frame, "odom");
      EXPECT_EQ(poses[1].time_s, 2.0);
      expect_message_pose(poses[1].pose);
    }
    EXPECT_TRUE(poses_in("tf/tfMessage", kind, MessageWriter(kind).add<std::uint32_t>(0).bytes()).empty());
  }
}

TEST(RosMessages, a_header_without_a_time_has_that_of_the_log) {
  const auto time = [](double header_s) {
    const std::string bytes =
        MessageWriter(MessageKind::cdr).header(header_s, "map").vector({0, 0, 0}).bytes();
    return poses_in("geometry_msgs/PointStamped", MessageKind::cdr, bytes, 42.25).at(0).time_s;
  };
  EXPECT_EQ(time(0.0), 42.25);
  EXPECT_EQ(time(1e-9), 1e-9);
  EXPECT_EQ(time(1.75e9), 1.75e9);
}

TEST(RosMessages, a_quaternion_is_normalised_within_one_percent) {
  const auto with = [](double w, double x) {
    return MessageWriter(MessageKind::ros1)
        .header(1.0, "")
        .vector({0, 0, 0})
        .add(x)
        .add(0.0)
        .add(0.0)
        .add(w)
        .bytes();
  };
  const auto orientation = [&](double w, double x) {
    return only_pose_in("geometry_msgs/PoseStamped", MessageKind::ros1, with(w, x)).pose.orientation;
  };
  EXPECT_NEAR(orientation(0.6 * 1.009, 0.8 * 1.009).w(), 0.6, 1e-15);
  EXPECT_NEAR(orientation(0.6 * 0.991, 0.8 * 0.991).norm(), 1.0, 1e-15);
  const auto known = [&](double w, double x) {
    return only_pose_in("geometry_msgs/PoseStamped", MessageKind::ros1, with(w, x)).has_orientation;
  };
  EXPECT_TRUE(known(0.6, 0.8));
  EXPECT_FALSE(known(0.0, 0.0));
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  for (const auto& [w, x] :
       {std::pair(1.02, 0.0), {0.98, 0.0}, {1e-12, 0.0}, {nan, 0.0}, {1.0, nan}, {infinity, 0.0}}) {
    // 16 bytes of header and 24 of the position come before.
    expect_message_fails("geometry_msgs/PoseStamped", MessageKind::ros1, with(w, x),
                         "log.bag:byte 40: the quaternion has length");
  }
}

/// A fix in degrees.
std::string fix_message(MessageKind kind, std::int8_t status, const Eigen::Vector3d& place,
                        std::uint8_t covariance_type) {
  Eigen::Matrix3d C;
  C << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  MessageWriter fix(kind);
  fix.header(3.0, "gps").add(status).add<std::uint16_t>(15).vector(place).matrix(C).add(covariance_type);
  return fix.bytes();
}

TEST(RosMessages, a_fix_is_in_radians_with_its_covariance_first) {
  for (const MessageKind kind : kMessageKinds) {
    const RosPose fix =
        only_pose_in("sensor_msgs/NavSatFix", kind, fix_message(kind, 2, {45.0, -180.0, 12.5}, 1));
    EXPECT_NEAR(fix.pose.position.x(), std::numbers::pi / 4.0, 1e-15);
    EXPECT_NEAR(fix.pose.position.y(), -std::numbers::pi, 1e-15);
    EXPECT_EQ(fix.pose.position.z(), 12.5);
    ASSERT_TRUE(fix.covariance.has_value());
    EXPECT_EQ((*fix.covariance)(0, 1), 2.0);
    EXPECT_EQ((*fix.covariance)(2, 0), 7.0);
    EXPECT_EQ(fix.covariance->bottomRows<3>().norm(), 0.0);
    EXPECT_EQ(fix.covariance->rightCols<3>().norm(), 0.0);
    EXPECT_FALSE(only_pose_in("sensor_msgs/NavSatFix", kind, fix_message(kind, 0, {1, 2, 3}, 0))
                     .covariance.has_value())
        << "of a kind that is not known";
    const RosPose none = only_pose_in("sensor_msgs/NavSatFix", kind, fix_message(kind, -1, {1, 2, 3}, 1));
    EXPECT_TRUE(none.pose.position.array().isNaN().all()) << "without a fix";
  }
}

TEST(RosMessages, a_message_that_ends_too_early_is_an_error_at_any_byte) {
  for (const MessageKind kind : kMessageKinds) {
    MessageWriter odometry(kind), tf(kind);
    odometry.header(1.0, "map").text("base").pose(kMessagePose).matrix(message_covariance());
    tf.add<std::uint32_t>(1).header(1.0, "map").text("base").pose(kMessagePose);
    for (const auto& [type, whole] :
         {std::pair<std::string, std::string>("nav_msgs/Odometry", odometry.bytes()),
          {"tf2_msgs/TFMessage", tf.bytes()},
          {"sensor_msgs/NavSatFix", fix_message(kind, 0, {1, 2, 3}, 1)}}) {
      EXPECT_EQ(poses_in(type, kind, whole).size(), 1U);
      for (std::size_t cut = 0; cut < whole.size(); ++cut) {
        expect_message_fails(type, kind, whole.substr(0, cut), "are left: cut off, or corrupted");
      }
    }
  }
}

TEST(RosMessages, lengths_beyond_the_message_are_errors) {
  for (const MessageKind kind : kMessageKinds) {
    for (const std::uint32_t many : {2U, 0x7fffffffU, 0xffffffffU}) {
      MessageWriter tf(kind), text(kind);
      tf.add(many).header(1.0, "map").text("base").pose(kMessagePose);
      expect_message_fails("tf2_msgs/TFMessage", kind, tf.bytes(), "are left: cut off, or corrupted");
      if (kind == MessageKind::ros1) text.add<std::uint32_t>(0);
      text.add<std::uint32_t>(1).add<std::uint32_t>(0).add(many);
      expect_message_fails("nav_msgs/Odometry", kind, text.bytes(), "are left: cut off, or corrupted");
    }
  }
}

TEST(RosMessages, another_representation_is_an_error_that_names_it) {
  for (const auto& [bytes, name] :
       {std::pair<std::string, std::string>(std::string("\0\x03\0\0", 4), "0003"),  // with parameters
        {std::string("\0\x08\0\0", 4), "0008"},
        {std::string("\x01\x01\0\0", 4), "0101"}}) {
    expect_message_fails("nav_msgs/Odometry", MessageKind::cdr, bytes + std::string(400, '\0'),
                         "byte 0: a message of the representation " + name + "; read is plain CDR");
  }
}

TEST(RosMessages, types_say_what_they_hold) {
  for (const char* type : {"nav_msgs/Odometry", "geometry_msgs/PoseWithCovarianceStamped"}) {
    EXPECT_TRUE(ros_pose_type(type)->covariance);
    EXPECT_TRUE(ros_pose_type(type)->has_orientation);
  }
  EXPECT_TRUE(ros_pose_type("sensor_msgs/NavSatFix")->geodetic);
  EXPECT_FALSE(ros_pose_type("geometry_msgs/PointStamped")->has_orientation);
  EXPECT_TRUE(ros_pose_type("tf/tfMessage")->several);
  for (const char* type : {"", "nav_msgs/msg/Odometry", "nav_msgs/Path", "Odometry"}) {
    EXPECT_EQ(ros_pose_type(type), nullptr) << type;
  }
}

}  // namespace
}  // namespace credence::internal
