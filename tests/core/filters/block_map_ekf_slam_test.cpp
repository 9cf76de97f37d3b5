#include "core/filters/block_map_ekf_slam.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/filters/ekf_slam.h"

namespace credence::internal {
namespace {

using PlanarEkf = EkfSlam<PlanarModel>;
using PlanarBlockMap = BlockMapEkfSlam<PlanarModel>;
using PlanarObservation = Observation<PlanarModel>;

/// A vehicle on a circle among landmarks, seen where they are near, in another order at each step.
class Drive {
 public:
  Drive(int landmarks, double range_m, std::size_t most_seen, unsigned seed)
      : range_m_(range_m), most_seen_(most_seen), bits_(seed) {
    for (int i = 0; i < landmarks; ++i) {
      const double a = 2.0 * std::numbers::pi * i / landmarks, r = 10.0 + 3.0 * std::sin(5.0 * i);
      landmarks_.emplace_back(r * std::cos(a), r * std::sin(a) + 10.0);
    }
  }

  const Control& control() const { return control_; }
  const std::vector<Point>& landmarks() const { return landmarks_; }
  static PlanarModel model() { return {.vehicle = {}, .dt_s = 1.0}; }
  static Eigen::Matrix2d Q() { return Eigen::Vector2d(0.01, 0.0004).asDiagonal(); }
  static Eigen::Matrix2d R() { return Eigen::Vector2d(0.01, 0.0003).asDiagonal(); }
  static Pose start() { return Pose::Zero(); }
  static Eigen::Matrix3d start_covariance() { return Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal(); }

  std::vector<PlanarObservation> step() {
    const Control u = control_ + Control(0.1 * normal_(bits_), 0.02 * normal_(bits_));
    pose_ = model().vehicle.moved(pose_, u, 1.0);
    ++k_;
    std::vector<PlanarObservation> seen;
    for (std::size_t i = 0; i < landmarks_.size() && seen.size() < most_seen_; ++i) {
      const std::size_t id = (i * 7 + static_cast<std::size_t>(k_)) % landmarks_.size();
      if ((landmarks_[id] - pose_.head<2>()).norm() > range_m_) continue;
      RangeBearing z = measure_range_bearing(pose_, landmarks_[id]);
      z += RangeBearing(0.1 * normal_(bits_), 0.017 * normal_(bits_));
      z[1] = wrap_angle(z[1]);
      seen.push_back({static_cast<int>(id), z});
    }
    return seen;
  }

 private:
  double range_m_;
  std::size_t most_seen_;
  std::mt19937_64 bits_;
  std::normal_distribution<double> normal_;
  std::vector<Point> landmarks_;
  Control control_{1.0, 0.1};
  Pose pose_ = start();
  int k_ = 0;
};

PlanarEkf dense_filter(InflationSolution solution, std::span<const Anchor<PlanarModel>> anchors = {}) {
  InflationRule rule;
  rule.inflation = Inflation::map;
  rule.solution = solution;
  return {Drive::model(), Drive::Q(), Drive::R(), rule, anchors};
}

/// The largest entry of A − B relative to the variances of B.
double relative_difference(const Matrix& A, const Matrix& B) {
  const Vector scale = B.diagonal().cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (A - B) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

double least_relative_eigenvalue(const Matrix& A, const Vector& variances) {
  const Vector scale = variances.cwiseSqrt().cwiseInverse();
  const Matrix scaled = scale.asDiagonal() * A * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Matrix>(scaled, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

struct World {
  int landmarks;
  double range_m;
  std::size_t most_seen;
  int read_every;  ///< steps; reading applies what is pending
  MapBound bound = MapBound::least_trace;
};

class BlockMapAgainstDense : public testing::TestWithParam<World> {};

TEST_P(BlockMapAgainstDense, IsTheSameFilter) {
  const World& world = GetParam();
  Drive drive(world.landmarks, world.range_m, world.most_seen, 7);
  std::vector<Anchor<PlanarModel>> anchors;
  if (world.landmarks == 6) anchors.push_back({3, drive.landmarks()[3]});
  const bool batch = world.bound == MapBound::batch;
  PlanarEkf dense = dense_filter(batch ? InflationSolution::batch : InflationSolution::sequential, anchors);
  PlanarBlockMap filter(Drive::model(), Drive::Q(), Drive::R(), world.bound, anchors);
  filter.keep_gain(true);
  // The bound of a batch goes by thresholds, the last of which are steps of 1e-4, and rounding decides where
  // a matrix is at one: the dense filter is given the other's state where it is read.
  const double magnified = batch ? 1e8 : 1.0;
  dense.reset(Drive::start(), Drive::start_covariance());
  filter.reset(Drive::start(), Drive::start_covariance());
  const int steps = world.landmarks == 20 ? 1000 : 200;
  for (int k = 0; k < steps; ++k) {
    const std::vector<PlanarObservation> seen = drive.step();
    dense.predict(drive.control());
    filter.predict(drive.control());
    const UpdateResult expected = dense.update(seen), result = filter.update(seen);
    ASSERT_TRUE(expected.ok && result.ok);
    ASSERT_EQ(result.initialised, expected.initialised);
    ASSERT_EQ(result.dof, expected.dof);
    ASSERT_NEAR(result.nis, expected.nis, magnified * 1e-10 * (1.0 + expected.nis)) << "step " << k;
    ASSERT_NEAR(result.trace_prior, expected.trace_prior, magnified * 1e-12 * expected.trace_prior)
        << "step " << k;
    if (result.dof > 0) {
      ASSERT_LT((filter.innovation_covariance() - dense.innovation_covariance()).norm(),
                magnified * 1e-12 * dense.innovation_covariance().norm());
      ASSERT_LT((filter.gain() - dense.gain()).norm(), magnified * 1e-11 * dense.gain().norm());
    }
    if ((k + 1) % world.read_every != 0) continue;
    ASSERT_LT((filter.state() - dense.state()).cwiseAbs().maxCoeff(), magnified * 1e-11) << "step " << k;
    ASSERT_LT(relative_difference(filter.covariance().dense(), dense.covariance()), magnified * 1e-12)
        << "step " << k;
    if (batch) {
      const std::vector<int> ids(filter.landmarks().begin(), filter.landmarks().end());
      dense.reset(filter.state(), filter.covariance().dense(), ids);
    }
  }
  EXPECT_EQ(static_cast<std::size_t>(filter.covariance().landmarks()),
            drive.landmarks().size() - anchors.size());
}

INSTANTIATE_TEST_SUITE_P(Worlds, BlockMapAgainstDense,
                         testing::Values(World{20, 12.0, 100, 8}, World{20, 100.0, 1, 50},
                                         World{6, 8.0, 100, 200}, World{1, 100.0, 1, 10},
                                         World{33, 7.0, 3, 4}, World{20, 12.0, 100, 8, MapBound::batch},
                                         World{6, 8.0, 100, 10, MapBound::batch},
                                         World{33, 7.0, 3, 4, MapBound::batch},
                                         // Eighty scalars: three groups.
                                         World{40, 100.0, 100, 8, MapBound::batch}));

/// D − P, in units of the standard deviations of P, where P is what the exact filter (batch, Joseph form)
/// makes of the covariance that `filter` has: its least eigenvalue.
double least_eigenvalue_above_exact(PlanarBlockMap& filter, PlanarEkf& exact,
                                    const std::vector<PlanarObservation>& seen) {
  const std::vector<int> ids(filter.landmarks().begin(), filter.landmarks().end());
  exact.reset(filter.state(), filter.covariance().dense(), ids);
  EXPECT_TRUE(exact.update(seen).ok && filter.update(seen).ok);
  const Matrix& P = exact.covariance();
  return least_relative_eigenvalue(filter.covariance().dense() - P, P.diagonal());
}

TEST(BlockMapEkfSlam, IsAboveTheExactPosteriorAtEveryStep) {
  for (const MapBound bound : {MapBound::least_trace, MapBound::batch, MapBound::drop}) {
    Drive drive(20, 12.0, 100, 11);
    PlanarBlockMap filter(Drive::model(), Drive::Q(), Drive::R(), bound);
    filter.reset(Drive::start(), Drive::start_covariance());
    PlanarEkf exact(Drive::model(), Drive::Q(), Drive::R());
    double least = 0.0;
    for (int k = 0; k < 1000; ++k) {
      // New landmarks apart: their Jacobians depend on the posterior pose, which is not the exact filter's.
      std::vector<PlanarObservation> known, first_seen;
      for (const PlanarObservation& o : drive.step()) {
        (filter.offset_of(o.landmark) < 0 ? first_seen : known).push_back(o);
      }
      filter.predict(drive.control());
      least = std::min(least, least_eigenvalue_above_exact(filter, exact, known));
      if (!first_seen.empty())
        least = std::min(least, least_eigenvalue_above_exact(filter, exact, first_seen));
    }
    EXPECT_GT(least, -1e-12);
  }
}

void expect_the_same_monobot(InflationSolution solution, MapBound bound) {
  using Scalar = MonobotModel::Scalar;
  InflationRule rule;
  rule.inflation = Inflation::map;
  rule.solution = solution;
  const std::vector<Anchor<MonobotModel>> anchors = {{9, Scalar(4.0)}};
  EkfSlam<MonobotModel> dense({}, Scalar(0.1), Scalar(0.2), rule, anchors);
  BlockMapEkfSlam<MonobotModel> filter({}, Scalar(0.1), Scalar(0.2), bound, anchors);
  dense.reset(Vector::Zero(1), Matrix::Identity(1, 1), {});
  filter.reset(Scalar(0.0), Scalar(1.0));
  for (int k = 0; k < 200; ++k) {
    std::vector<Observation<MonobotModel>> seen;
    for (int i = 0; i <= std::min(k / 5, 11); ++i) {
      if ((i + k) % 3 == 0) seen.push_back({i, Scalar(i + std::sin(k + i))});
    }
    dense.predict(Scalar(0.1));
    filter.predict(Scalar(0.1));
    ASSERT_TRUE(dense.update(seen).ok && filter.update(seen).ok);
    if (k % 5 != 0) continue;
    ASSERT_LT((filter.state() - dense.state()).cwiseAbs().maxCoeff(), 1e-12);
    ASSERT_LT(relative_difference(filter.covariance().dense(), dense.covariance()), 1e-12) << "step " << k;
  }
}

TEST(BlockMapEkfSlam, TheMonobotIsTheSameFilterToo) {
  expect_the_same_monobot(InflationSolution::sequential, MapBound::least_trace);
  expect_the_same_monobot(InflationSolution::batch, MapBound::batch);
}

TEST(BlockMapEkfSlam, DropKeepsTheMapAndMovesTheVehicle) {
  // With P_ff = D kept, the vehicle's terms are those of the exact update with that prior.
  Drive drive(6, 100.0, 1, 3);
  PlanarBlockMap filter(Drive::model(), Drive::Q(), Drive::R(), MapBound::drop);
  filter.reset(Drive::start(), Drive::start_covariance());
  for (int k = 0; k < 6; ++k) {
    filter.predict(drive.control());
    filter.update(drive.step());
  }
  const Matrix before = filter.covariance().dense();
  for (int k = 0; k < 20; ++k) {
    filter.predict(drive.control());
    filter.update(drive.step());
  }
  const Matrix after = filter.covariance().dense();
  EXPECT_TRUE(after.bottomRightCorner(12, 12) == before.bottomRightCorner(12, 12));
  EXPECT_NE(after.topRows(3), before.topRows(3));
}

/// Mean over the last of ten loops of tr P before an update, the map decorrelated: six landmarks seen within
/// 12 m of a circle of 63 m, without noise, so that the estimates are the truth
/// (scenarios/map_solutions.toml).
template <typename Filter>
double trace_over_the_tenth_loop(Filter filter) {
  Pose pose(10.0, 0.0, 0.5 * std::numbers::pi);
  filter.reset(pose, Eigen::Matrix3d(Eigen::Vector3d(0.0025, 0.0025, 0.0003).asDiagonal()));
  const Control control(1.0, 0.1);
  double sum = 0.0;
  for (int k = 0; k < 630; ++k) {
    pose = Drive::model().vehicle.moved(pose, control, 1.0);
    std::vector<PlanarObservation> seen;
    for (int i = 0; i < 6; ++i) {
      const double angle = std::numbers::pi * (2 * i + 1) / 6.0, radius = i % 2 == 0 ? 7.0 : 13.0;
      const RangeBearing z =
          measure_range_bearing(pose, Point(radius * std::cos(angle), radius * std::sin(angle)));
      if (z[0] <= 12.0) seen.push_back({i, z});
    }
    filter.predict(control);
    const UpdateResult result = filter.update(seen);
    EXPECT_TRUE(result.ok);
    if (k >= 567) sum += result.trace_prior / 63.0;
  }
  return sum;
}

TEST(BlockMapEkfSlam, ABatchComesWithinATenthOfTheExactLeastTrace) {
  const auto dense = [](InflationSolution solution) {
    return PlanarEkf(Drive::model(), Drive::Q(), Drive::R(),
                     {.inflation = Inflation::map, .solution = solution, .constant = {}});
  };
  const auto block_map = [](MapBound bound) {
    return PlanarBlockMap(Drive::model(), Drive::Q(), Drive::R(), bound);
  };
  const double exact = trace_over_the_tenth_loop(dense(InflationSolution::min_trace));
  const double batch = trace_over_the_tenth_loop(block_map(MapBound::batch));
  const double sequential = trace_over_the_tenth_loop(block_map(MapBound::least_trace));
  RecordProperty("exact", std::to_string(exact));
  RecordProperty("batch", std::to_string(batch));
  RecordProperty("sequential", std::to_string(sequential));
  EXPECT_LT(batch, 1.1 * exact);
  EXPECT_GT(sequential, 1.2 * exact);
}

TEST(BlockMapEkfSlam, CorrelatedMeasurementNoiseIsWhitened) {
  // One landmark has no map to decorrelate: the filter is the exact one, for any R.
  Eigen::Matrix2d R;
  R << 0.01, 0.001, 0.001, 0.0003;
  Drive drive(1, 100.0, 1, 5);
  PlanarEkf exact(Drive::model(), Drive::Q(), R);
  PlanarBlockMap filter(Drive::model(), Drive::Q(), R);
  filter.keep_gain(true);
  exact.reset(Drive::start(), Drive::start_covariance());
  filter.reset(Drive::start(), Drive::start_covariance());
  for (int k = 0; k < 50; ++k) {
    const std::vector<PlanarObservation> seen = drive.step();
    exact.predict(drive.control());
    filter.predict(drive.control());
    ASSERT_TRUE(exact.update(seen).ok && filter.update(seen).ok);
    ASSERT_LT(relative_difference(filter.covariance().dense(), exact.covariance()), 1e-11);
    ASSERT_LT((filter.state() - exact.state()).norm(), 1e-11);
    if (k > 0) {
      ASSERT_LT((filter.gain() - exact.gain()).norm(), 1e-11 * exact.gain().norm());
    }
  }
}

TEST(BlockMapEkfSlam, StaysPositiveDefiniteForALongTime) {
  // Little noise, so that rounding in P − l lᵀ has its chance.
  Drive drive(12, 12.0, 4, 13);
  PlanarBlockMap filter(Drive::model(), 1e-4 * Drive::Q(), 1e-4 * Drive::R());
  filter.reset(Drive::start(), 1e-4 * Drive::start_covariance());
  for (int k = 0; k < 20000; ++k) {
    const std::vector<PlanarObservation> seen = drive.step();
    filter.predict(drive.control());
    ASSERT_TRUE(filter.update(seen).ok) << "step " << k;
  }
  const Vector e = Vector::Zero(filter.state().size());
  EXPECT_TRUE(arrow_nees(e, filter.covariance()).positive_definite);
}

TEST(BlockMapEkfSlam, WhatDoesNotFitIsRefused) {
  PlanarBlockMap filter(Drive::model(), Drive::Q(), Drive::R());
  const std::vector<int> ids = {0};
  EXPECT_THROW(filter.reset(Vector::Zero(4), ArrowCovariance(3, 2), ids), std::invalid_argument);
  EXPECT_THROW(filter.reset(Vector::Zero(5), ArrowCovariance(3, 2), ids), std::invalid_argument);
  EXPECT_THROW(filter.reset(Vector::Zero(3), ArrowCovariance(3, 1), {}), std::invalid_argument);
  EXPECT_THROW(filter.update(std::vector<PlanarObservation>{{-1, RangeBearing(1.0, 0.0)}}),
               std::invalid_argument);
  Eigen::Matrix2d R;
  R << 1.0, 2.0, 2.0, 1.0;
  EXPECT_THROW(PlanarBlockMap(Drive::model(), Drive::Q(), R), std::invalid_argument);
}

TEST(BlockMapEkfSlam, WithoutLandmarksOrMeasurementsItPredicts) {
  PlanarBlockMap filter(Drive::model(), Drive::Q(), Drive::R());
  filter.reset(Drive::start(), Drive::start_covariance());
  filter.predict(Control(1.0, 0.0));
  const UpdateResult result = filter.update({});
  EXPECT_TRUE(result.ok);
  EXPECT_EQ(result.dof, 0);
  EXPECT_EQ(result.nis, 0.0);
  EXPECT_DOUBLE_EQ(filter.state()[0], 1.0);
  EXPECT_EQ(filter.covariance().landmarks(), 0);
}

TEST(BlockMapEkfSlam, AFailedFactorisationIsAnOutcome) {
  PlanarBlockMap filter(Drive::model(), Drive::Q(), Eigen::Matrix2d::Zero());
  ArrowCovariance P(3, 2);
  P.append(ArrowCovariance::CrossMatrix::Zero(3, 2), ArrowCovariance::LandmarkMatrix::Zero(2, 2));
  const std::vector<int> ids = {0};
  filter.reset(Vector::LinSpaced(5, 0.0, 4.0), P, ids);
  const std::vector<PlanarObservation> seen = {{0, RangeBearing(1.0, 0.0)}};
  EXPECT_FALSE(filter.update(seen).ok);
}

}  // namespace
}  // namespace credence::internal
