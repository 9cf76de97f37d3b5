#include "montecarlo/worlds/planar/planar_bound.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/mirror.h"
#include "core/linear_algebra/psd_root.h"
#include "core/nan.h"
#include "core/stop_point.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_drive.h"

namespace credence {
namespace {

/// P of a pose and those landmarks of which something is known.
class KnownMap {
 public:
  /// Columns u of information Σ u uᵀ on the pose (3 rows) and a landmark (2 rows; none of an anchor).
  using Columns = Matrix;

  KnownMap(Index landmarks, const Eigen::Matrix3d& P0)
      : offset_(static_cast<std::size_t>(landmarks), -1),
        P_(Matrix::Zero(3 + 2 * landmarks, 3 + 2 * landmarks)) {
    P_.topLeftCorner<3, 3>() = P0;
  }

  void move(const Motion& motion, const Eigen::Matrix2d& Q) {
    const Eigen::Matrix3d pose = motion.F * P_.topLeftCorner<3, 3>() * motion.F.transpose();
    P_.topLeftCorner<3, 3>() = pose + motion.G * Q * motion.G.transpose();
    const Matrix rows = motion.F * P_.block(0, 3, 3, n_ - 3);
    P_.block(0, 3, 3, n_ - 3) = rows;
    P_.block(3, 0, n_ - 3, 3) = rows.transpose();
  }

  void learn_pose(const Columns& U) {
    if (U.cols() > 0) correct(P_.block(0, 0, n_, 3) * U, P_.topLeftCorner<3, 3>(), U);
  }

  void learn(Index landmark, const Columns& U) {
    if (U.cols() == 0) return;
    const Index at = offset_[static_cast<std::size_t>(landmark)];
    if (at < 0) return start(landmark, U);
    const Matrix W = P_.block(0, 0, n_, 3) * U.topRows(3) + P_.block(0, at, n_, 2) * U.bottomRows(2);
    Matrix own(5, 5);
    own << P_.topLeftCorner<3, 3>(), P_.block<3, 2>(0, at), P_.block<2, 3>(at, 0), P_.block<2, 2>(at, at);
    correct(W, own, U);
  }

  /// Of the layout's states; NaN where nothing is known.
  Vector variances() const {
    Vector all = Vector::Constant(P_.rows(), kNaN);
    all.head<3>() = P_.diagonal().head<3>();
    for (std::size_t i = 0; i < offset_.size(); ++i) {
      if (offset_[i] >= 0)
        all.segment<2>(3 + 2 * static_cast<Index>(i)) = P_.diagonal().segment<2>(offset_[i]);
    }
    return all;
  }

 private:
  /// P ← (P⁻¹ + U Uᵀ)⁻¹ by W = P U, of which `own` are the states of U.
  void correct(const Matrix& W, const Matrix& own, const Columns& U) {
    const Matrix S = Matrix::Identity(U.cols(), U.cols()) + U.transpose() * own * U;
    const Eigen::LLT<Matrix> root(S);
    const Matrix half = root.matrixL().solve(Matrix(W.transpose()));
    auto P = P_.topLeftCorner(n_, n_);
    P.noalias() -= half.transpose() * half;
  }

  /// A landmark of which nothing was known: the rest of its information tells of the pose.
  void start(Index landmark, const Columns& U) {
    const Matrix A = U * U.transpose();
    const Eigen::Matrix2d own = A.bottomRightCorner<2, 2>();
    constexpr double kSingular = 1e-12;
    if (!(own.determinant() > kSingular * own(0, 0) * own(1, 1))) return;
    const Eigen::Matrix2d D = own.inverse();
    const Eigen::Matrix<double, 2, 3> C = -D * A.bottomLeftCorner<2, 3>();
    const Eigen::Matrix3d rest = A.topLeftCorner<3, 3>() + A.topRightCorner<3, 2>() * C;
    // Of one truth nothing is left but rounding.
    if (rest.trace() > kSingular * A.topLeftCorner<3, 3>().trace()) {
      const Matrix symmetric = 0.5 * (rest + rest.transpose());
      learn_pose(psd_root(symmetric));
    }
    const Matrix rows = C * P_.block(0, 0, 3, n_);
    P_.block(n_, 0, 2, n_) = rows;
    P_.block(0, n_, n_, 2) = rows.transpose();
    P_.block<2, 2>(n_, n_) = D + rows.leftCols<3>() * C.transpose();
    offset_[static_cast<std::size_t>(landmark)] = n_;
    n_ += 2;
  }

  std::vector<Index> offset_;  ///< by number; −1: unknown
  Index n_ = 3;
  Matrix P_;
};

/// Of one sight of a landmark at `rho` in the axes of the vehicle: R^{-1/2} H, transposed, by the error of a
/// pose with this heading and that of the landmark.
Eigen::Matrix<double, 5, 2> told(double heading, const Point& rho, const RangeBearing& std) {
  const Pose at(0.0, 0.0, heading);
  const auto predicted = predict_range_bearing(at, Eigen::Rotation2Dd(heading) * rho);
  Eigen::Matrix<double, 5, 2> U;
  U << predicted.H_r.transpose(), predicted.H_l.transpose();
  return U * std.cwiseInverse().asDiagonal();
}

/// Multiplications that two seconds are enough for.
constexpr double kMostWork = 4e9;

}  // namespace

PosteriorBound planar_bound(const Scenario& scenario) {
  if (std::string reason = no_bound_reason(scenario); !reason.empty()) return {.reason = std::move(reason)};
  const PlanarWorld world = make_planar_world(scenario);
  const PlanarNoise noise = PlanarNoise::of(scenario);
  const NoiseSource source = noise_source(scenario);
  const Index landmarks = world.states();
  const auto n = static_cast<double>(3 + 2 * landmarks);
  const double work = static_cast<double>(world.controls.size() * world.landmarks.size()) * n * n;
  if (work > kMostWork) {
    return {.reason = fmt::format("{} landmarks and {} steps are too many for it", landmarks,
                                  world.controls.size())};
  }
  const Eigen::Matrix2d Q = noise.control_std.cwiseAbs2().asDiagonal();
  std::vector<PlanarDrive> drives(static_cast<std::size_t>(kBoundRuns), PlanarDrive(world, noise, source));
  for (std::size_t i = 0; i < drives.size(); ++i) drives[i].start(static_cast<std::int64_t>(i));
  // What Jacobians at the truth claim differs little from truth to truth: a mean over fewer of them.
  const auto claims = static_cast<std::size_t>(std::clamp(kMostWork / work, 1.0, 16.0));
  std::vector<KnownMap> at_truth(claims, KnownMap(landmarks, noise.initial_covariance()));
  KnownMap bound(landmarks, noise.initial_covariance());
  BoundRecorder recorder(planar_layout(world), kBoundRuns);
  Pose nominal = world.start;
  std::vector<Eigen::Matrix<double, 5, 5>> information(world.landmarks.size());
  for (std::size_t k = 1; k <= world.controls.size(); ++k) {
    stop_point();
    for (auto& of_landmark : information) of_landmark.setZero();
    const Control& u = world.controls[k - 1];
    const Motion unmoved = world.vehicle.move(nominal, u, world.dt_s);
    bound.move(unmoved, Q);
    nominal = unmoved.pose;
    for (std::size_t i = 0; i < drives.size(); ++i) {
      PlanarDrive& drive = drives[i];
      if (i < claims) at_truth[i].move(world.vehicle.move(drive.pose(), u, world.dt_s), Q);
      drive.move(k);
      const Pose& pose = drive.pose();
      for (const auto& sight : drive.observe(k)) {
        const Index landmark = sight.landmark;
        const auto number = static_cast<std::size_t>(landmark);
        const Point rho = Eigen::Rotation2Dd(-pose[2]) * Point(world.landmarks[number] - pose.head<2>());
        const auto U = told(nominal[2], rho, noise.measurement_std);
        information[number] += U * U.transpose() / static_cast<double>(kBoundRuns);
        if (i >= claims) continue;
        const Matrix own = told(pose[2], rho, noise.measurement_std);
        if (landmark < landmarks) {
          at_truth[i].learn(landmark, own);
        } else {
          at_truth[i].learn_pose(own.topRows(3));
        }
      }
    }
    for (std::size_t i = 0; i < information.size(); ++i) {
      if (information[i].isZero(0.0)) continue;
      if (std::cmp_less(i, landmarks)) {
        bound.learn(static_cast<Index>(i), psd_root(information[i]));
      } else {
        bound.learn_pose(psd_root(Matrix(information[i].topLeftCorner<3, 3>())));
      }
    }
    Vector claimed = Vector::Zero(3 + 2 * landmarks);
    for (const KnownMap& map : at_truth) claimed += map.variances() / static_cast<double>(claims);
    recorder.add(bound.variances(), claimed);
  }
  return recorder.take();
}

}  // namespace credence
