#include "montecarlo/worlds/planar/planar_bound.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "core/filters/delayed_covariance.h"
#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/matrix_buffer.h"
#include "core/manifold/rotation.h"
#include "core/nan.h"
#include "core/stop_point.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/planar/planar_simulation.h"

namespace credence::internal {
namespace {

/// Of a pose and a landmark.
using Information = Eigen::Matrix<double, 5, 5>;
/// Measurements of variance one of a pose and a landmark: their Hᵀ H is the information.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor, 5, 5>;

/// As many rows as the information has ranks.
Rows rows_of(const Information& J) {
  constexpr double kNothing = 1e-14;  // rounding
  const Eigen::SelfAdjointEigenSolver<Information> modes(J);
  const auto& strengths = modes.eigenvalues();
  Rows H(5, 5);
  Index rank = 0;
  for (int i = 0; i < 5; ++i) {
    if (strengths[i] <= kNothing * strengths[4]) continue;
    H.row(rank++) = std::sqrt(strengths[i]) * modes.eigenvectors().col(i).transpose();
  }
  return H.topRows(rank);
}

/// What was learned of a landmark; of an anchor, which is no state, the pose's part counts.
struct Lesson {
  Index landmark = 0;  ///< anchors have the numbers beyond the landmarks
  Rows H;
};

/// P of a pose and those landmarks of which something is known.
class KnownMap {
 public:
  KnownMap(Index landmarks, const Eigen::Matrix3d& P0) : offset_(static_cast<std::size_t>(landmarks), -1) {
    P_.set(P0);
  }

  void move(const Motion& motion, const Eigen::Matrix2d& Q) {
    auto columns = P_.vehicle_columns();
    const Eigen::Matrix3d pose = motion.F * columns.topRows<3>() * motion.F.transpose();
    columns.topRows<3>() = pose + motion.G * Q * motion.G.transpose();
    auto cross = columns.bottomRows(columns.rows() - 3);
    for (Index i = 0; i < cross.rows(); ++i) cross.row(i) = (cross.row(i) * motion.F.transpose()).eval();
    P_.vehicle_changed();
  }

  /// A step's lessons: those of what is known together, then what begins.
  void learn(std::span<const Lesson> lessons) {
    rows_.clear();
    for (const Lesson& lesson : lessons) {
      if (!begins(lesson)) add_rows(offset_of(lesson.landmark), lesson.H);
    }
    correct();
    for (const Lesson& lesson : lessons) {
      if (begins(lesson)) start(lesson);
    }
  }

  /// Of the layout's states; NaN where nothing is known.
  Vector variances() const {
    Vector all = Vector::Constant(3 + 2 * std::ssize(offset_), kNaN);
    all.head<3>() = P_.variances().head<3>();
    for (std::size_t i = 0; i < offset_.size(); ++i) {
      if (offset_[i] < 0) continue;
      all.segment<2>(3 + 2 * static_cast<Index>(i)) = P_.variances().segment<2>(offset_[i]);
    }
    return all;
  }

 private:
  /// A measurement of variance one: of the pose, and of the landmark at an offset unless that is negative.
  struct Row {
    Index offset;
    Eigen::Matrix<double, 1, 5, Eigen::RowMajor> h;
  };

  bool is_anchor(Index landmark) const { return landmark >= std::ssize(offset_); }
  Index offset_of(Index landmark) const {
    return is_anchor(landmark) ? -1 : offset_[static_cast<std::size_t>(landmark)];
  }
  bool begins(const Lesson& lesson) const {
    return !is_anchor(lesson.landmark) && offset_of(lesson.landmark) < 0;
  }

  void add_rows(Index offset, const Rows& H) {
    for (Index i = 0; i < H.rows(); ++i) rows_.push_back({offset, H.row(i)});
  }

  /// P ← P − P Hᵀ (H P Hᵀ + I)⁻¹ H P with the rows H.
  void correct() {
    if (rows_.empty()) return;
    const Index n = P_.size(), m = std::ssize(rows_);
    const auto pose = P_.vehicle_columns();
    auto landmark = columns_.resize(whole_panels(n), 2);
    auto PHt = PHt_.resize(whole_panels(n), m);
    const double* from[5] = {pose.col(0).data(), pose.col(1).data(), pose.col(2).data(),
                             landmark.col(0).data(), landmark.col(1).data()};
    for (Index i = 0, before = -1; i < m; ++i) {
      const auto& [offset, h] = rows_[static_cast<std::size_t>(i)];
      if (offset >= 0 && offset != before) P_.copy_columns(offset, 2, landmark);
      if (offset >= 0) before = offset;
      factor_.combine({from, static_cast<std::size_t>(offset < 0 ? 3 : 5)}, h.data(), n,
                      {.y = PHt.col(i).data()});
    }
    Matrix S = Matrix::Identity(m, m);
    for (Index i = 0; i < m; ++i) {
      const auto& [offset, h] = rows_[static_cast<std::size_t>(i)];
      S.row(i).noalias() += h.head<3>() * PHt.topRows<3>();
      if (offset >= 0) S.row(i).noalias() += h.tail<2>() * PHt.middleRows<2>(offset);
    }
    factor_.compute(S, PHt.topRows(n), Vector::Zero(m));
    P_.downdate(factor_);
  }

  /// A landmark of which nothing was known: the rest of its information tells of the pose.
  void start(const Lesson& lesson) {
    const Information J = lesson.H.transpose() * lesson.H;
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
      rows_.clear();
      add_rows(-1, rows_of(of_pose));
      correct();
    }
    const Index n = P_.size();
    const Matrix cross = C * P_.vehicle_columns().transpose();
    P_.append(cross, D + cross.leftCols<3>() * C.transpose());
    offset_[static_cast<std::size_t>(lesson.landmark)] = n;
  }

  std::vector<Index> offset_;  ///< by number; −1: unknown
  DelayedCovariance P_{3};
  PanelCholesky factor_;
  std::vector<Row> rows_;
  MatrixBuffer columns_, PHt_;
};

/// One observation of a landmark at `rho` in the axes of the vehicle, by the error of a pose with this
/// rotation and that of the landmark.
Eigen::Matrix<double, 2, 5> told(const Eigen::Matrix2d& rotation, const Point& rho, const RangeBearing& std) {
  const auto predicted = predict_range_bearing(Pose::Zero(), rotation * rho);
  Eigen::Matrix<double, 2, 5> H;
  H << predicted.H_r, predicted.H_l;
  return std.cwiseInverse().asDiagonal() * H;
}

/// n² a step and landmark: for more, some seconds are not enough; up to the second, all truths are looked at.
constexpr double kMostWork = 4e10, kWorkOfAllTruths = 4e9;

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
  const auto claims = static_cast<std::size_t>(std::clamp(kWorkOfAllTruths / work, 1.0, 16.0));
  std::vector<KnownMap> at_truth(claims, KnownMap(landmarks, noise.initial_covariance()));
  KnownMap bound(landmarks, noise.initial_covariance());
  BoundRecorder recorder(planar_layout(world), kBoundRuns);
  Pose nominal = world.start;
  std::vector<Information> information(world.landmarks.size());
  std::vector<Lesson> lessons;
  for (std::size_t k = 1; k <= world.controls.size(); ++k) {
    stop_point();
    for (Information& of_landmark : information) of_landmark.setZero();
    const Control& u = world.controls[k - 1];
    const Motion unmoved = world.vehicle.move(nominal, u, world.dt_s);
    bound.move(unmoved, Q);
    nominal = unmoved.pose;
    const Eigen::Matrix2d from_nominal = rotation(nominal[2]);
    for (std::size_t i = 0; i < simulations.size(); ++i) {
      PlanarSimulation& simulation = simulations[i];
      if (i < claims) at_truth[i].move(world.vehicle.move(simulation.pose(), u, world.dt_s), Q);
      simulation.move(k);
      const Pose& pose = simulation.pose();
      const Eigen::Matrix2d from_vehicle = rotation(pose[2]);
      for (const auto& observation : simulation.observe(k)) {
        const auto number = static_cast<std::size_t>(observation.landmark);
        const Point rho = from_vehicle.transpose() * Point(world.landmarks[number] - pose.head<2>());
        const Eigen::Matrix<double, 2, 5> H = told(from_nominal, rho, noise.measurement_std);
        information[number] += H.transpose() * H / static_cast<double>(kBoundRuns);
        if (i < claims) {
          lessons.push_back({observation.landmark, told(from_vehicle, rho, noise.measurement_std)});
        }
      }
      if (i < claims) at_truth[i].learn(lessons);
      lessons.clear();
    }
    for (std::size_t i = 0; i < information.size(); ++i) {
      if (!information[i].isZero(0.0)) lessons.push_back({static_cast<Index>(i), rows_of(information[i])});
    }
    bound.learn(lessons);
    lessons.clear();
    Vector claimed = Vector::Zero(3 + 2 * landmarks);
    for (const KnownMap& map : at_truth) claimed += map.variances() / static_cast<double>(claims);
    recorder.add(bound.variances(), claimed);
  }
  return recorder.take();
}

}  // namespace credence::internal
