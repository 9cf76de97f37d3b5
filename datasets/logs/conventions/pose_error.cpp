#include "datasets/logs/conventions/pose_error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/manifold/angle.h"
#include "core/manifold/chart.h"
#include "core/manifold/sek3.h"

namespace credence::internal {
namespace {

SE3 group_element(const SpatialPose& pose) { return {SO3(pose.orientation), pose.position}; }

Chart chart_of(PoseErrorAxes axes) {
  return axes.orientation == OrientationError::world ? Chart::left : Chart::right;
}

/// The rotation vector e in another unit.
Eigen::Vector3d in_unit(const Eigen::Vector3d& e, RotationUnit unit) {
  if (unit == RotationUnit::vector) return e;
  if (unit == RotationUnit::half_vector) return 0.5 * e;
  const double angle = e.norm();
  return angle > 0.0 ? Eigen::Vector3d(std::sin(0.5 * angle) / angle * e) : Eigen::Vector3d(0.5 * e);
}

/// The Jacobian of in_unit.
Eigen::Matrix3d unit_jacobian(const Eigen::Vector3d& e, RotationUnit unit) {
  if (unit == RotationUnit::vector) return Eigen::Matrix3d::Identity();
  const double angle = e.norm();
  if (unit == RotationUnit::half_vector || !(angle > 0.0)) return 0.5 * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d axis = e / angle;
  const double share = std::sin(0.5 * angle) / angle;
  return share * Eigen::Matrix3d::Identity() +
         (0.5 * std::cos(0.5 * angle) - share) * axis * axis.transpose();
}

/// The rotation vector of the orientation's error, in the body or the world.
Eigen::Vector3d rotation_error(const Eigen::Quaterniond& estimate, const Eigen::Quaterniond& truth,
                               OrientationError kind) {
  return kind == OrientationError::world ? rotation_log(estimate * truth.conjugate())
                                         : rotation_log(truth.conjugate() * estimate);
}

bool is_rotation_vector(OrientationError kind) {
  return kind == OrientationError::body || kind == OrientationError::world;
}

/// D of rpy(R Exp(δ)) = rpy(R) + D δ, from ω = E d(rpy) in the body.
Eigen::Matrix3d roll_pitch_yaw_jacobian(const Eigen::Quaterniond& R) {
  const Eigen::Vector3d angles = roll_pitch_yaw(R);
  const double cr = std::cos(angles[0]), sr = std::sin(angles[0]);
  const double cp = std::cos(angles[1]), tp = std::tan(angles[1]);
  Eigen::Matrix3d D;
  D << 1.0, sr * tp, cr * tp, 0.0, cr, -sr, 0.0, sr / cp, cr / cp;
  return D;
}

}  // namespace

std::span<const Index> estimated_components(PoseErrorAxes axes) {
  static constexpr std::array<Index, 6> kAll = {0, 1, 2, 3, 4, 5};
  static constexpr std::array<Index, 3> kPlanar = {0, 1, 5};
  if (axes.orientation == OrientationError::planar) return kPlanar;
  return kAll;
}

Eigen::Vector3d rotation_log(const Eigen::Quaterniond& R) { return SO3(R).Log(); }

Eigen::Vector3d roll_pitch_yaw(const Eigen::Quaterniond& R) {
  const Eigen::Matrix3d m = R.toRotationMatrix();
  // R(2, 0) = −sin(pitch); rounding may take it beyond 1.
  return {std::atan2(m(2, 1), m(2, 2)), std::asin(std::clamp(-m(2, 0), -1.0, 1.0)),
          std::atan2(m(1, 0), m(0, 0))};
}

PoseError pose_error(const SpatialPose& estimate, const SpatialPose& truth, PoseErrorAxes axes) {
  PoseError error;
  if (axes.position == PositionError::twist) {
    error = minus(group_element(estimate), group_element(truth), chart_of(axes));
  } else {
    const Eigen::Vector3d position = estimate.position - truth.position;
    error.head<3>() = axes.position == PositionError::body
                          ? Eigen::Vector3d(estimate.orientation.conjugate() * position)
                          : position;
    if (is_rotation_vector(axes.orientation)) {
      error.tail<3>() = rotation_error(estimate.orientation, truth.orientation, axes.orientation);
    } else {
      error.tail<3>() = roll_pitch_yaw(estimate.orientation) - roll_pitch_yaw(truth.orientation);
      for (double& angle : error.tail<3>()) angle = wrap_angle(angle);
    }
  }
  error.tail<3>() = in_unit(error.tail<3>(), axes.unit);
  return error;
}

PoseCovariance pose_error_jacobian(const SpatialPose& estimate, const SpatialPose& truth,
                                   PoseErrorAxes axes) {
  // x̂ ⊟ x is minus the coordinates of x about x̂, on the group as in rotation vectors.
  const SE3 x_hat = group_element(estimate), x = group_element(truth);
  PoseCovariance D;
  if (axes.position == PositionError::twist) {
    D = -minus_jacobian(x, x_hat, chart_of(axes));
  } else {
    const Eigen::Matrix3d R = truth.orientation.toRotationMatrix();
    const Eigen::Matrix3d R_hat = estimate.orientation.toRotationMatrix();
    D.setZero();
    D.topLeftCorner<3, 3>() =
        axes.position == PositionError::body ? Eigen::Matrix3d(-R_hat.transpose() * R) : Eigen::Matrix3d(-R);
    D.bottomRightCorner<3, 3>() =
        is_rotation_vector(axes.orientation)
            ? Eigen::Matrix3d(-minus_jacobian(x.rotation(), x_hat.rotation(), chart_of(axes)))
            : Eigen::Matrix3d(-roll_pitch_yaw_jacobian(truth.orientation));
  }
  if (axes.unit != RotationUnit::vector) {
    const Eigen::Vector3d e = rotation_error(estimate.orientation, truth.orientation, axes.orientation);
    D.bottomRows<3>() = (unit_jacobian(e, axes.unit) * D.bottomRows<3>()).eval();
  }
  return D;
}

PoseCovariance frame_jacobian(const SpatialPose& estimate, const SpatialPose& truth,
                              const Eigen::Vector3d& centre, PoseErrorAxes axes) {
  // Exp(w) x = x Exp(Ad(x⁻¹) w).
  const SpatialPose about{truth.position - centre, truth.orientation};
  return pose_error_jacobian(estimate, truth, axes) * group_element(inverse(about)).adjoint();
}

PoseCovariance error_change(const SpatialPose& estimate, const SpatialPose& truth, PoseErrorAxes from,
                            PoseErrorAxes to) {
  // J = D_to D_from⁻¹.
  const PoseCovariance D_from = pose_error_jacobian(estimate, truth, from);
  const PoseCovariance D_to = pose_error_jacobian(estimate, truth, to);
  return D_from.transpose().partialPivLu().solve(D_to.transpose()).transpose();
}

PoseCovariance transported(const PoseCovariance& P, const SpatialPose& pose, PoseErrorAxes from,
                           PoseErrorAxes to) {
  if (from == to) return P;
  const PoseCovariance J = error_change(pose, pose, from, to);
  return J * P * J.transpose();
}

void move_on_body(const SpatialPose& A, PoseErrorAxes axes, SpatialPose& pose, PoseCovariance& P) {
  constexpr PoseErrorAxes kRight{.position = PositionError::twist, .orientation = OrientationError::body};
  const PoseCovariance J = group_element(inverse(A)).adjoint();
  const PoseCovariance right = transported(P, pose, axes, kRight);
  pose = {pose.position + pose.orientation * A.position, (pose.orientation * A.orientation).normalized()};
  P = transported(J * right * J.transpose(), pose, kRight, axes);
}

SpatialPose inverse(const SpatialPose& pose) {
  return {pose.orientation.conjugate() * -pose.position, pose.orientation.conjugate()};
}

}  // namespace credence::internal
