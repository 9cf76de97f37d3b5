#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/linear_algebra/matrix_product.h"
#include "core/manifold/sek3.h"
#include "core/types.h"

namespace credence::internal {

/// Where an estimator takes its Jacobians.
enum class SpatialPoint {
  estimate,  ///< at its newest estimates
  truth,     ///< at the truth: the yardstick
  first,     ///< at the first estimate of each state ([Huang 2008])
};

/// In which chart a correction moves the estimate and P keeps its numbers.
enum class SpatialChart {
  componentwise,  ///< vectors by differences, the attitude by Exp(φ) R
  pose,           ///< the pose as one element of SE(3), Exp(ξ) X; landmarks by differences
  whole,          ///< pose and landmarks as one element of SE_{1+N}(3), Exp(ξ) X: the right-invariant error
};

/// An estimator of spatial SLAM.
struct SpatialKind {
  std::string_view name, meaning;
  SpatialPoint point;
  SpatialChart chart;
};

/// The estimators there are ([Zhang 2017], Table II).
std::span<const SpatialKind> spatial_kinds();
/// Throws std::invalid_argument for a name that there is not.
const SpatialKind& spatial_kind(std::string_view name);

/// A landmark seen in the frame of the vehicle, z = Rᵀ(l − p) + w, w ~ N(0, R).
struct SpatialObservation {
  int landmark = 0;
  Eigen::Vector3d z, variances;  ///< R is their diagonal, positive
};

/// A step of odometry: R⁺ = R Exp(ω), p⁺ = p + R v.
struct SpatialControl {
  Eigen::Vector3d v, omega;               ///< m, rad
  Eigen::Matrix<double, 6, 1> variances;  ///< of the noise on v and ω
};

/// Where vehicle and landmarks really are. Only the ideal filter looks.
struct SpatialTruth {
  SE3 before, now;
  std::span<const Eigen::Vector3d> landmarks{};
};

/// Rows of a Jacobian: what a landmark's observation tells of the pose and of the landmark.
struct SpatialRows {
  int landmark;
  Eigen::Matrix<double, 3, 6> pose;
  Eigen::Matrix3d own;
};

/// A Kalman filter for SLAM in space, of any SpatialKind: x = [pose; landmarks in the order of first
/// observation], n = 6 + 3 × landmarks.
///
/// P is kept componentwise, (δp, φ, δl): p = p̂ + δp, R = Exp(φ) R̂, l = l̂ + δl. With away = l̂ − p̂
///
///   Φ = [I, −(p̂⁺ − p̂)^; 0, I],   H = R̂ᵀ [−I, away^, I].
///
/// In the charts of a group ξ_i = δ_i + x̂_i^ φ, and an estimator of such a chart differs by its correction
/// alone (ChartEkf): x̂⁺ = Exp(ξ) x̂, and as P keeps its numbers there, here δ_i ← δ_i − (x̂_i⁺ − x̂_i)^ φ. A
/// prediction costs O(n), a correction by m numbers n² m / 2 multiply-adds.
class SpatialSlam {
 public:
  using PoseMatrix = Eigen::Matrix<double, 6, 6>;

  /// `landmarks`: most that can be seen, numbered from 0.
  SpatialSlam(const SpatialKind& kind, Index landmarks) : kind_(kind), most_(landmarks) {}

  /// Starts with an empty map; P is componentwise.
  void reset(const SE3& pose, const PoseMatrix& P);
  void predict(const SpatialControl& read, const SpatialTruth& truth);
  /// Corrects by the known landmarks in one batch and places the others. False where S is not positive
  /// definite, and nothing was changed.
  bool update(std::span<const SpatialObservation> observations, const SpatialTruth& truth);

  Index size() const { return P_.rows(); }
  const SE3& pose() const { return pose_; }
  bool is_finite() const { return pose_.translation().allFinite() && P_.diagonal().allFinite(); }
  bool has_own_chart() const { return kind_.chart != SpatialChart::componentwise; }
  const Matrix& covariance() const { return P_; }  ///< componentwise; the lower triangle
  PoseMatrix pose_covariance() const;              ///< componentwise, full

  /// The error of the pose (δp, φ) or ξ, truth less estimate, componentwise or in the chart of the filter.
  Eigen::Matrix<double, 6, 1> pose_error(const SE3& truth, bool own_chart) const;
  PoseMatrix own_pose_covariance() const;
  /// The error of all landmarks and its covariance (lower triangle) in the chart of the filter; allocates.
  struct MapError {
    Vector error;
    Matrix P;
  };
  MapError map_error(const SpatialTruth& truth) const;

  const Vector& innovation() const { return nu_; }            ///< ν of the last correction
  const Matrix& innovation_covariance() const { return S_; }  ///< its S
  /// Of the last step in the filter's own chart: Φ of the pose, and the rows of observations and of
  /// placements.
  const PoseMatrix& motion_jacobian() const { return F_; }
  std::span<const SpatialRows> rows() const { return rows_; }

 private:
  using Rows = Eigen::Matrix<double, 3, 6>;

  Eigen::Vector3d landmark(Index i) const { return landmarks_[static_cast<std::size_t>(i)]; }
  /// x̂ ← x̂ ⊞ δ, P ← P − W Wᵀ carried along.
  void correct(const Vector& delta, const Matrix& W);
  void place(const SpatialObservation& observation, const SpatialTruth& truth);
  /// Keeps rows that hold componentwise, in the filter's own chart; the landmark is at `about`.
  void show(int number, Rows H_r, const Eigen::Matrix3d& H_l, const Eigen::Vector3d& about);
  /// Where Jacobians of the pose and of a landmark are taken.
  const SE3& pose_point(const SpatialTruth& truth) const;
  Eigen::Vector3d landmark_point(Index i, const SpatialTruth& truth) const;

  SpatialKind kind_;
  Index most_;
  SE3 pose_, first_pose_;
  std::vector<Eigen::Vector3d> landmarks_, first_;  ///< in the order of the state
  std::vector<int> numbers_;                        ///< of the landmarks, in this order
  std::vector<Index> places_;                       ///< by number; −1: not in the state
  Matrix P_, S_;
  Vector nu_;
  PoseMatrix F_ = PoseMatrix::Identity();
  std::vector<SpatialRows> rows_;
  MatrixProduct product_;
};

}  // namespace credence::internal
