#include "montecarlo/worlds/planar/planar_bound.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/linear_algebra/decompositions.h"
#include "core/manifold/rotation.h"
#include "core/nan.h"
#include "core/stop_point.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_simulation.h"

namespace credence::internal {
namespace {

/// Of a pose and a landmark.
using Information = Eigen::Matrix<double, 5, 5>;

/// P of a pose and those landmarks of which something is known.
class KnownMap {
 public:
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

  /// Of an anchor, which is no state, with a number beyond the landmarks, the pose's part alone.
  void learn(Index landmark, const Information& information) {
    const auto number = static_cast<std::size_t>(landmark);
    if (number >= offset_.size()) return correct(-1, information);
    if (offset_[number] < 0) return start(number, information);
    correct(offset_[number], information);
  }

  /// Of the layout's states; NaN where nothing is known.
  Vector variances() const {
    Vector all = Vector::Constant(P_.rows(), kNaN);
    all.head<3>() = P_.diagonal().head<3>();
    for (std::size_t i = 0; i < offset_.size(); ++i) {
      if (offset_[i] < 0) continue;
      all.segment<2>(3 + 2 * static_cast<Index>(i)) = P_.diagonal().segment<2>(offset_[i]);
    }
    return all;
  }

 private:
  /// P ← (P⁻¹ + J)⁻¹ = P − P_s (I + J P_ss)⁻¹ J P_sᵀ of the states s that J is of: the pose, and the landmark
  /// at an offset unless that is negative.
  void correct(Index offset, const Information& J) {
    if (offset < 0) return correct_states<3>(offset, J.topLeftCorner<3, 3>());
    correct_states<5>(offset, J);
  }

  template <int m>
  void correct_states(Index offset, const Eigen::Matrix<double, m, m>& J) {
    using Square = Eigen::Matrix<double, m, m>;
    using Columns = Eigen::Matrix<double, Eigen::Dynamic, m>;
    Columns columns(n_, m);
    Square own;
    columns.template leftCols<3>() = P_.block(0, 0, n_, 3);
    if constexpr (m == 5) {
      columns.template rightCols<2>() = P_.block(0, offset, n_, 2);
      own.template bottomRows<2>() = columns.template middleRows<2>(offset);
    }
    own.template topRows<3>() = columns.template topRows<3>();
    const Square spread = Square::Identity() + J * own;
    const Square lost = Eigen::PartialPivLU<Square>(spread).solve(J);
    // Of so few columns a product is cheaper without blocks.
    const Columns weighted = columns.lazyProduct(Square(0.5 * (lost + lost.transpose())));
    P_.topLeftCorner(n_, n_) -= weighted.lazyProduct(columns.transpose());
  }

  /// A landmark of which nothing was known: the rest of its information tells of the pose.
  void start(std::size_t number, const Information& J) {
    const Eigen::Matrix2d own = J.bottomRightCorner<2, 2>();
    constexpr double kSingular = 1e-12;
    if (!(own.determinant() > kSingular * own(0, 0) * own(1, 1))) return;
    const Eigen::Matrix2d D = own.inverse();
    const Eigen::Matrix<double, 2, 3> C = -D * J.bottomLeftCorner<2, 3>();
    const Eigen::Matrix3d rest = J.topLeftCorner<3, 3>() + J.topRightCorner<3, 2>() * C;
    // Of one truth nothing is left but rounding.
    if (rest.trace() > kSingular * J.topLeftCorner<3, 3>().trace()) {
      Information of_pose = Information::Zero();
      of_pose.topLeftCorner<3, 3>() = 0.5 * (rest + rest.transpose());
      correct(-1, of_pose);
    }
    const Matrix rows = C * P_.block(0, 0, 3, n_);
    P_.block(n_, 0, 2, n_) = rows;
    P_.block(0, n_, n_, 2) = rows.transpose();
    P_.block<2, 2>(n_, n_) = D + rows.leftCols<3>() * C.transpose();
    offset_[number] = n_;
    n_ += 2;
  }

  std::vector<Index> offset_;  ///< by number; −1: unknown
  Index n_ = 3;
  Matrix P_;
};

/// Hᵀ R⁻¹ H of one observation of a landmark at `rho` in the axes of the vehicle, by the error of a pose with
/// this heading and that of the landmark.
Information told(double heading, const Point& rho, const RangeBearing& std) {
  const auto predicted = predict_range_bearing(Pose(0.0, 0.0, heading), rotation(heading) * rho);
  Eigen::Matrix<double, 2, 5> H;
  H << predicted.H_r, predicted.H_l;
  return H.transpose() * std.cwiseAbs2().cwiseInverse().asDiagonal() * H;
}

/// Multiplications that two seconds are enough for.
constexpr double kMostWork = 4e9;

}  // namespace

PosteriorBound planar_bound(const Scenario& scenario) {
  const PlanarWorld world = make_planar_world(scenario);
  const PlanarNoise noise = PlanarNoise::of(scenario);
  if ((noise.measurement_std.array() == 0.0).any()) return {.reason = kBoundOfNoisyMeasurements};
  const NoiseSource source = noise_source(scenario);
  const Index landmarks = world.states();
  const auto n = static_cast<double>(3 + 2 * landmarks);
  const double work = static_cast<double>(world.controls.size() * world.landmarks.size()) * n * n;
  if (work > kMostWork) {
    return {.reason = fmt::format("{} landmarks and {} steps are too many for it", landmarks,
                                  world.controls.size())};
  }
  const Eigen::Matrix2d Q = noise.control_std.cwiseAbs2().asDiagonal();
  std::vector<PlanarSimulation> simulations(static_cast<std::size_t>(kBoundRuns),
                                            PlanarSimulation(world, noise, source));
  for (std::size_t i = 0; i < simulations.size(); ++i) simulations[i].start(static_cast<std::int64_t>(i));
  // What Jacobians at the truth claim differs little from truth to truth: a mean over fewer of them.
  const auto claims = static_cast<std::size_t>(std::clamp(kMostWork / work, 1.0, 16.0));
  std::vector<KnownMap> at_truth(claims, KnownMap(landmarks, noise.initial_covariance()));
  KnownMap bound(landmarks, noise.initial_covariance());
  BoundRecorder recorder(planar_layout(world), kBoundRuns);
  Pose nominal = world.start;
  std::vector<Information> information(world.landmarks.size());
  for (std::size_t k = 1; k <= world.controls.size(); ++k) {
    stop_point();
    for (Information& of_landmark : information) of_landmark.setZero();
    const Control& u = world.controls[k - 1];
    const Motion unmoved = world.vehicle.move(nominal, u, world.dt_s);
    bound.move(unmoved, Q);
    nominal = unmoved.pose;
    for (std::size_t i = 0; i < simulations.size(); ++i) {
      PlanarSimulation& simulation = simulations[i];
      if (i < claims) at_truth[i].move(world.vehicle.move(simulation.pose(), u, world.dt_s), Q);
      simulation.move(k);
      const Pose& pose = simulation.pose();
      const Eigen::Matrix2d to_vehicle = rotation(pose[2]).transpose();
      for (const auto& observation : simulation.observe(k)) {
        const auto number = static_cast<std::size_t>(observation.landmark);
        const Point rho = to_vehicle * Point(world.landmarks[number] - pose.head<2>());
        information[number] += told(nominal[2], rho, noise.measurement_std) / static_cast<double>(kBoundRuns);
        if (i < claims) at_truth[i].learn(observation.landmark, told(pose[2], rho, noise.measurement_std));
      }
    }
    for (std::size_t i = 0; i < information.size(); ++i) {
      if (!information[i].isZero(0.0)) bound.learn(static_cast<Index>(i), information[i]);
    }
    Vector claimed = Vector::Zero(3 + 2 * landmarks);
    for (const KnownMap& map : at_truth) claimed += map.variances() / static_cast<double>(claims);
    recorder.add(bound.variances(), claimed);
  }
  return recorder.take();
}

}  // namespace credence::internal
