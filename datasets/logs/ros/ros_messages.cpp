#include "datasets/logs/ros/ros_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/manifold/angle.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// Reads the fields of a message in its order.
class MessageFields {
 public:
  MessageFields(const ByteCursor& message, RosTopic::Encoding encoding) : bytes_(message) {
    if (encoding == RosTopic::Encoding::ros1) return;
    cdr_ = true;
    // The encapsulation: 0, kind, two bytes of options. Kinds 0 and 1 are CDR of version 1 (big, little
    // endian), 6 and 7 of version 2, which aligns to 4 at most.
    const std::uint64_t begin = bytes_.position();
    const auto zero = bytes_.take<std::uint8_t>();
    const auto kind = bytes_.take<std::uint8_t>();
    if (zero != 0 || (kind != 0 && kind != 1 && kind != 6 && kind != 7)) {
      bytes_.fail_at(
          begin, fmt::format("a message of the representation {:02x}{:02x}; read is plain CDR", zero, kind));
    }
    bytes_.skip(2);
    bytes_.set_order(kind % 2 == 1 ? std::endian::little : std::endian::big);
    largest_alignment_ = kind >= 6 ? 4 : 8;
    begin_ = bytes_.taken();
  }

  template <class T>
  T take() {
    if (cdr_) {
      const std::uint64_t alignment = std::min<std::uint64_t>(sizeof(T), largest_alignment_);
      bytes_.skip((alignment - (bytes_.taken() - begin_) % alignment) % alignment);
    }
    return bytes_.take<T>();
  }

  std::string_view text() {
    const auto size = take<std::uint32_t>();
    std::string_view value = bytes_.take_text(size);
    // CDR counts the zero at the end.
    if (cdr_ && value.ends_with('\0')) value.remove_suffix(1);
    return value;
  }

  Eigen::Vector3d vector() {
    const double x = take<double>(), y = take<double>(), z = take<double>();
    return {x, y, z};
  }

  /// Nothing for zeros.
  std::optional<Eigen::Quaterniond> quaternion() {
    constexpr double kUnitTolerance = 0.01;
    const std::uint64_t begin = bytes_.position();
    const Eigen::Vector3d v = vector();
    const Eigen::Quaterniond q(take<double>(), v.x(), v.y(), v.z());
    if (q.coeffs().isZero(0.0)) return std::nullopt;
    if (!(std::abs(q.norm() - 1.0) <= kUnitTolerance)) {
      bytes_.fail_at(begin, fmt::format("the quaternion has length {:.4g}, not 1", q.norm()));
    }
    return q.normalized();
  }

  void pose(RosPose& out) {
    out.pose.position = vector();
    const std::optional<Eigen::Quaterniond> orientation = quaternion();
    out.has_orientation = orientation.has_value();
    out.pose.orientation = orientation.value_or(Eigen::Quaterniond::Identity());
  }

  /// Row by row.
  template <int n>
  Eigen::Matrix<double, n, n> matrix() {
    Eigen::Matrix<double, n, n> m;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) m(i, j) = take<double>();
    }
    return m;
  }

  /// std_msgs/Header.
  void header(double log_time_s, RosPose& out) {
    if (!cdr_) take<std::uint32_t>();  // a number in sequence
    const auto seconds = take<std::uint32_t>();
    const auto nanoseconds = take<std::uint32_t>();
    const double time = static_cast<double>(seconds) + 1e-9 * static_cast<double>(nanoseconds);
    out.time_s = time > 0.0 ? time : log_time_s;
    out.frame = text();
  }

  void transform(double log_time_s, RosPose& out) {
    header(log_time_s, out);
    out.child_frame = text();
    pose(out);
  }

 private:
  ByteCursor bytes_;
  bool cdr_ = false;
  std::uint64_t begin_ = 0, largest_alignment_ = 8;
};

constexpr RosPoseType kTypes[] = {
    {.type = "nav_msgs/Odometry", .covariance = true},
    {.type = "geometry_msgs/PoseWithCovarianceStamped", .covariance = true},
    {.type = "geometry_msgs/PoseStamped"},
    {.type = "geometry_msgs/TransformStamped"},
    {.type = "tf2_msgs/TFMessage", .several = true},
    {.type = "tf/tfMessage", .several = true},
    {.type = "geometry_msgs/PointStamped", .has_orientation = false},
    {.type = "sensor_msgs/NavSatFix", .covariance = true, .has_orientation = false, .geodetic = true},
};

/// Latitude, longitude, altitude; NaN without a fix.
void read_fix(MessageFields& fields, RosPose& out) {
  const auto status = fields.take<std::int8_t>();
  fields.take<std::uint16_t>();  // which satellites
  const Eigen::Vector3d place = fields.vector();
  out.pose.position = {kRadiansPerDegree * place.x(), kRadiansPerDegree * place.y(), place.z()};
  if (status < 0) out.pose.position.setConstant(kNaN);
  const Eigen::Matrix3d covariance = fields.matrix<3>();
  if (fields.take<std::uint8_t>() != 0) {  // a covariance is known
    out.covariance = PoseCovariance::Zero();
    out.covariance->topLeftCorner<3, 3>() = covariance;
  }
}

}  // namespace

const RosPoseType* ros_pose_type(std::string_view type) {
  const auto found = std::ranges::find(kTypes, type, &RosPoseType::type);
  return found == std::end(kTypes) ? nullptr : &*found;
}

void read_ros_poses(const RosPoseType& type, RosTopic::Encoding encoding, double log_time_s,
                    const ByteCursor& message, std::vector<RosPose>& poses) {
  poses.clear();
  MessageFields fields(message, encoding);
  if (type.several) {
    const auto count = fields.take<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) fields.transform(log_time_s, poses.emplace_back());
    return;
  }
  RosPose& out = poses.emplace_back();
  if (type.type == "geometry_msgs/TransformStamped") return fields.transform(log_time_s, out);
  fields.header(log_time_s, out);
  if (type.geodetic) return read_fix(fields, out);
  if (type.type == "nav_msgs/Odometry") out.child_frame = fields.text();
  if (type.has_orientation) {
    fields.pose(out);
  } else {
    out.pose.position = fields.vector();
  }
  if (type.covariance) out.covariance = fields.matrix<6>();
}

}  // namespace credence::internal
