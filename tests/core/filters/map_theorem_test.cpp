// theory, section 5, Theorem 3: with inflation of the map alone by the least trace, by the bound of a batch,
// or by dropping, the sum of the map's variances never rises between initialisations, whatever the Jacobians
// and what is seen.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/filters/block_map_ekf_slam.h"
#include "core/filters/ekf_slam.h"
#include "core/filters/linear_filter.h"

namespace credence::internal {
namespace {

/// Rounding of a sum of variances.
constexpr double kRounding = 1e-13;

/// The plane with every Jacobian taken at a pose and a landmark drawn anew at each use.
struct RandomModel {
  static constexpr int kPose = 3, kControl = 2, kLandmark = 2, kMeasurement = 2;

  struct Draws {
    std::mt19937_64 bits{7};
    PlacedLandmark placed;  ///< the last
  };
  Draws* draws = nullptr;

  double random(double from, double to) const {
    return std::uniform_real_distribution<double>(from, to)(draws->bits);
  }
  Point point() const { return {random(-10.0, 10.0), random(-10.0, 10.0)}; }
  Pose anywhere() const {
    Pose pose;
    pose << point(), random(-3.0, 3.0);
    return pose;
  }
  Motion move(const Pose& pose, const Control&) const {
    Motion motion = Vehicle{}.move(anywhere(), Control(1.0, 0.1), 1.0);
    motion.pose = pose;
    return motion;
  }
  PredictedRangeBearing predict(const Pose&, const Point&) const {
    PredictedRangeBearing predicted = predict_range_bearing(anywhere(), point());
    predicted.z.setZero();
    return predicted;
  }
  PlacedLandmark place(const Pose&, const RangeBearing&) const {
    return draws->placed = place_landmark(anywhere(), {random(1.0, 20.0), random(-3.0, 3.0)});
  }
  static RangeBearing innovation(const RangeBearing&, const RangeBearing&) { return RangeBearing::Zero(); }
  static void wrap_pose(Pose&) {}
};

const Eigen::Matrix2d kQ = Eigen::Vector2d(0.01, 0.0004).asDiagonal();
const Eigen::Matrix2d kR = Eigen::Vector2d(0.01, 0.0003).asDiagonal();

InflationRule map_rule(InflationSolution solution) {
  return {.inflation = Inflation::map, .solution = solution, .constant = {}};
}

double map_trace(const Matrix& P) { return P.diagonal().tail(P.rows() - 3).sum(); }
double map_trace(const ArrowCovariance& P) { return P.trace_of_map(); }

Eigen::Matrix3d vehicle_block(const EkfSlam<RandomModel>& filter) {
  return filter.covariance().topLeftCorner<3, 3>();
}
Eigen::Matrix3d vehicle_block(const BlockMapEkfSlam<RandomModel>& filter) { return filter.pose_covariance(); }

/// tr D from one inflation of the map to the next, with what the theorem says of it.
struct MapTrace {
  long rises = 0;      ///< without a new landmark
  double last = 0.0;   ///< tr D
  double first = 0.0;  ///< tr D when all landmarks were known
  bool within = true;  ///< every new landmark: √tr D_new ≤ √tr D_old + √tr B

  void add(double now, double new_variance) {
    if (new_variance > 0.0) {
      within = within && std::sqrt(now) <= (std::sqrt(last) + std::sqrt(new_variance)) * (1.0 + kRounding);
      first = now;
    } else {
      rises += now > last * (1.0 + kRounding) ? 1 : 0;
    }
    last = now;
  }
};

/// Six landmarks, one to three of them seen at a step, at most one of these new.
template <typename Filter>
MapTrace follow(Filter& filter, RandomModel::Draws& draws, bool sequential, int steps) {
  std::mt19937_64 choice(3);
  MapTrace trace;
  double new_variance = 0.0;  // tr B of a landmark that no inflation has met yet
  filter.reset(Pose::Zero(), Eigen::Matrix3d(0.1 * Eigen::Matrix3d::Identity()));
  for (int k = 0; k < steps; ++k) {
    filter.predict(Control::Zero());
    const int known = static_cast<int>(filter.landmarks().size()), candidates = std::min(known + 1, 6);
    const int first = static_cast<int>(choice() % 6), count = 1 + static_cast<int>(choice() % 3);
    std::vector<Observation<RandomModel>> seen;
    for (int i = 0; i < std::min(count, candidates); ++i) {
      seen.push_back({(first + i) % candidates, RangeBearing::Zero()});
    }
    if constexpr (requires { filter.inflated_prior(); }) {
      if (!sequential) trace.add(map_trace(filter.inflated_prior()), new_variance);
    }
    const UpdateResult update = filter.update(seen);
    EXPECT_TRUE(update.ok) << "step " << k;
    if (!update.ok) return trace;
    const auto& [position, J_r, J_z] = draws.placed;
    new_variance = update.initialised == 0
                       ? 0.0
                       : (J_r * vehicle_block(filter) * J_r.transpose() + J_z * kR * J_z.transpose()).trace();
    if (sequential) trace.add(map_trace(filter.covariance()), new_variance);
  }
  return trace;
}

void expect_theorem(const MapTrace& trace) {
  EXPECT_EQ(trace.rises, 0);
  EXPECT_TRUE(trace.within);
  EXPECT_LE(trace.last, trace.first);
}

TEST(MapTheorem, HoldsInThePlaneForAnyJacobians) {
  for (const InflationSolution solution :
       {InflationSolution::sequential, InflationSolution::batch, InflationSolution::drop}) {
    RandomModel::Draws draws;
    EkfSlam<RandomModel> filter({&draws}, kQ, kR, map_rule(solution));
    expect_theorem(follow(filter, draws, true, 20'000));
  }
  RandomModel::Draws draws;
  EkfSlam<RandomModel> filter({&draws}, kQ, kR, map_rule(InflationSolution::min_trace));
  expect_theorem(follow(filter, draws, false, 1000));
}

TEST(MapTheorem, HoldsForTheBlockMapOverAHundredThousandSteps) {
  for (const MapBound bound : {MapBound::least_trace, MapBound::batch, MapBound::drop}) {
    RandomModel::Draws draws;
    BlockMapEkfSlam<RandomModel> filter({&draws}, kQ, kR, bound);
    const MapTrace trace = follow(filter, draws, true, 100'000);
    expect_theorem(trace);
    if (bound == MapBound::drop) {
      EXPECT_EQ(trace.last, trace.first);
    }
  }
}

// At its own estimates, a vehicle on a circle that reads noisy measurements of what is near: six landmarks.
TEST(MapTheorem, HoldsForTheEkfInThePlaneOverAHundredThousandSteps) {
  for (const MapBound bound : {MapBound::least_trace, MapBound::batch, MapBound::drop}) {
    BlockMapEkfSlam<PlanarModel> filter({.vehicle = {}, .dt_s = 1.0}, kQ, kR, bound);
    filter.reset(Pose(10.0, 0.0, 0.5 * std::numbers::pi),
                 Eigen::Matrix3d(0.01 * Eigen::Matrix3d::Identity()));
    std::mt19937_64 bits(13);
    std::normal_distribution<double> normal;
    Pose truth(10.0, 0.0, 0.5 * std::numbers::pi);
    MapTrace trace;
    for (int k = 0; k < 100'000; ++k) {
      const Control u(1.0, 0.1);
      truth = Vehicle{}.moved(truth, u, 1.0);
      filter.predict(u + Control(0.1 * normal(bits), 0.02 * normal(bits)));
      std::vector<Observation<PlanarModel>> seen;
      for (int i = 0; i < 6; ++i) {
        const double angle = std::numbers::pi * i / 3.0, radius = i % 2 == 0 ? 7.0 : 13.0;
        const RangeBearing exact =
            measure_range_bearing(truth, Point(radius * std::cos(angle), radius * std::sin(angle)));
        if (exact[0] > 12.0) continue;
        seen.push_back({i, exact + RangeBearing(0.1 * normal(bits), 0.017 * normal(bits))});
      }
      const UpdateResult update = filter.update(seen);
      ASSERT_TRUE(update.ok) << "step " << k;
      const double now = filter.covariance().trace_of_map();
      if (update.initialised == 0) {
        trace.add(now, 0.0);
      } else {
        trace.first = trace.last = now;
      }
    }
    ASSERT_EQ(filter.landmarks().size(), 6U);
    EXPECT_EQ(trace.rises, 0);
    EXPECT_LE(trace.last, trace.first);
  }
}

TEST(MapTheorem, DoesNotHoldForThePairwiseSum) {
  RandomModel::Draws draws;
  EkfSlam<RandomModel> filter({&draws}, kQ, kR, map_rule(InflationSolution::pairwise));
  const MapTrace trace = follow(filter, draws, false, 5'000);
  EXPECT_GT(trace.rises, 1000);
  EXPECT_GT(trace.last, 10.0 * trace.first);
}

/// tr D of a monobot with four landmarks that sees one to four of them at a step.
MapTrace follow_monobot(InflationSolution solution, int steps) {
  LinearFilter filter(monobot_model(4, 0, 0.1, 0.1, 1.0), map_rule(solution));
  std::mt19937_64 choice(5);
  const bool sequential = map_rule(solution).is_sequential();
  MapTrace trace;
  trace.first = trace.last = 4.0;
  std::vector<Index> rows;
  for (int k = 0; k < steps; ++k) {
    rows.clear();
    for (Index row = 0; row < 4; ++row) {
      if (choice() % 2 == 0) rows.push_back(row);
    }
    const LinearFilterStep& step = filter.step(rows);
    EXPECT_TRUE(step.ok);
    trace.add((sequential ? step.P : step.P_prior).diagonal().tail(4).sum(), 0.0);
  }
  return trace;
}

TEST(MapTheorem, HoldsForTheMonobot) {
  expect_theorem(follow_monobot(InflationSolution::sequential, 100'000));
  expect_theorem(follow_monobot(InflationSolution::batch, 100'000));
  expect_theorem(follow_monobot(InflationSolution::drop, 100'000));
  expect_theorem(follow_monobot(InflationSolution::min_trace, 100'000));
  const MapTrace pairwise = follow_monobot(InflationSolution::pairwise, 20'000);
  EXPECT_GT(pairwise.rises, 1000);
  EXPECT_GT(pairwise.last, 100.0);
}

// (c) of the monobot, x_r its position: with w re-inflations, a row each or all rows at once, J = Σ 1/R over
// the rows of the window, ‖H_f‖² ≤ 1 a row, and the noise of the window at most doubles what w steps of it
// add.
TEST(MapTheorem, BoundsTheVehicleThatSeesItsMap) {
  constexpr double kProcess = 0.1, kMeasurement = 0.1;
  for (const InflationSolution solution : {InflationSolution::sequential, InflationSolution::batch,
                                           InflationSolution::drop, InflationSolution::min_trace}) {
    LinearFilter filter(monobot_model(4, 0, kProcess, kMeasurement, 1.0), map_rule(solution));
    const bool sequential = map_rule(solution).is_sequential();
    std::mt19937_64 choice(9);
    std::vector<Index> rows;
    double largest = 0.0;
    for (int k = 0; k < 20'000; ++k) {
      rows.clear();
      for (Index row = 0; row < 4; ++row) {
        if (choice() % 2 == 0) rows.push_back(row);
      }
      if (rows.empty()) rows.push_back(static_cast<Index>(choice() % 4));
      const LinearFilterStep& step = filter.step(rows);
      const double seen = static_cast<double>(rows.size()), tau = 4.0;  // tr D never exceeds that of P0
      const double window = sequential ? seen : 1.0, J = seen / kMeasurement, rho = 1.0 / kMeasurement;
      const double bound = 1.0 / J + rho * tau * window * (window + 3.0) / (2.0 * J);
      ASSERT_LE(step.P(0, 0), bound) << "step " << k;
      largest = std::max(largest, step.P(0, 0));
    }
    // Blind, the vehicle has no bound, while the map keeps its own.
    const double before = filter.step({}).P(0, 0);
    for (int k = 1; k < 1000; ++k) filter.step({});
    const LinearFilterStep& blind = filter.step({});
    EXPECT_NEAR(blind.P(0, 0), before + 1000.0 * kProcess, 1e-9);
    EXPECT_GT(blind.P(0, 0), 10.0 * largest);
    EXPECT_LE(blind.P.diagonal().tail(4).sum(), 4.0 * (1.0 + kRounding));
  }
}

}  // namespace
}  // namespace credence::internal
