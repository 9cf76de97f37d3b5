#include "datasets/logs/trajectory_errors.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using Vector3 = Eigen::Vector3d;

constexpr double kQuarterTurn = std::numbers::pi / 2.0;

Eigen::Quaterniond yawed(double a) { return Eigen::Quaterniond(Eigen::AngleAxisd(a, Vector3::UnitZ())); }

PoseCovariance diagonal_of(const std::vector<double>& variances) {
  return Eigen::Map<const PoseError>(variances.data()).asDiagonal();
}

/// One pose a second, from 0 s on.
Trajectory each_second(const std::vector<SpatialPose>& poses, const std::vector<PoseCovariance>& P = {}) {
  Trajectory trajectory;
  trajectory.poses = poses;
  trajectory.covariances = P;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    trajectory.time_s.push_back(static_cast<double>(i));
    trajectory.lines.push_back(static_cast<std::int64_t>(i) + 10);
  }
  return trajectory;
}

TEST(TrajectoryErrors, TheTimeOffsetIsAddedAndCovariancesAreWeighted) {
  const Trajectory truth = each_second({{Vector3(0, 0, 0)}, {Vector3(4, 0, 0)}},
                                       {PoseCovariance::Identity(), 5.0 * PoseCovariance::Identity()});
  const auto at = truth_at(truth, -0.25, {.max_time_difference_s = 1.0, .time_offset_s = 0.5});
  ASSERT_TRUE(at.has_value());  // 0.25 s: a quarter of the way
  EXPECT_DOUBLE_EQ(at->pose.position.x(), 1.0);
  EXPECT_TRUE(at->covariance.isApprox(2.0 * PoseCovariance::Identity(), 1e-15));
}

TEST(TrajectoryErrors, NoMotionNearTheAlignmentFitsBetter) {
  std::vector<SpatialPose> truth, estimate;
  for (int i = 0; i < 12; ++i) {
    const Vector3 p(std::cos(i), 2.0 * std::sin(0.7 * i), 0.5 * std::sin(1.3 * i));
    const Vector3 disturbed(std::sin(3.1 * i), std::cos(2.3 * i), std::sin(1.9 * i));
    truth.push_back({p});
    estimate.push_back({yawed(0.8) * p + Vector3(3, -1, 2) + 0.2 * disturbed});
  }
  const auto cost = [&](const Eigen::Isometry3d& motion) {
    double sum = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      sum += (estimate[i].position - motion * truth[i].position).squaredNorm();
    }
    return sum;
  };
  for (const auto alignment : {TruthAlignment::yaw, TruthAlignment::se3}) {
    const Eigen::Isometry3d best = align_truth(truth, estimate, alignment);
    const bool tilts = alignment == TruthAlignment::se3;
    if (!tilts) EXPECT_EQ(best.linear().col(2), Vector3::UnitZ());
    for (int axis = 0; axis < 3; ++axis) {
      for (const double by : {-1e-3, 1e-3}) {
        const Eigen::AngleAxisd turn(by, Vector3::Unit(axis));
        if (tilts || axis == 2) EXPECT_GT(cost(best * turn), cost(best));
        EXPECT_GT(cost(Eigen::Translation3d(by * Vector3::Unit(axis)) * best), cost(best));
      }
    }
  }
}

// The motion takes x to y and y to −x; the body's axes are those of the world turned by as much again.
TEST(TrajectoryErrors, TheMotionTurnsTheCovarianceOfTheTruthToo) {
  const Trajectory truth =
      each_second({{Vector3(1, 0, 0), yawed(kQuarterTurn)}}, {diagonal_of({1, 2, 3, 4, 5, 6})});
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = yawed(kQuarterTurn).toRotationMatrix();
  motion.translation() = Vector3(0, 0, 7);
  TruthPlacement placement;
  placement.motion = motion;
  const TruthComparison world(truth, {}, kFixedAxes, true, placement), body(truth, {}, {}, true, placement);
  const UncertainPose moved = world.truth_at(0.0).value();
  EXPECT_LT((moved.pose.position - Vector3(0, 1, 7)).norm(), 1e-15);
  EXPECT_LT((moved.covariance - diagonal_of({2, 1, 3, 5, 4, 6})).norm(), 1e-14);
  EXPECT_LT((body.truth_at(0.0)->covariance - diagonal_of({2, 1, 3, 5, 4, 6})).norm(), 1e-14)
      << "half a turn keeps the diagonal";
}

// Of half a rotation vector and of a quaternion's vector part an error of 1 turns by about 2 rad.
TEST(TrajectoryErrors, UnitsAreMetresAndRadiansWhereTheRotationIsInRadians) {
  const auto units = [](PoseErrorAxes axes, bool has_orientation = true) {
    Trajectory truth = each_second({{}});
    truth.has_orientation = has_orientation;
    return TruthComparison(truth, {}, axes, true).layout().units;
  };
  EXPECT_THAT(units({}), ElementsAre("m", "m", "m", "rad", "rad", "rad"));
  EXPECT_THAT(units({}, false), ElementsAre("m", "m", "m"));
  EXPECT_THAT(units({.orientation = OrientationError::rpy}), ElementsAre("m", "m", "m", "rad", "rad", "rad"));
  for (const RotationUnit unit : {RotationUnit::half_vector, RotationUnit::quaternion_part})
    EXPECT_THAT(units({.unit = unit}), ElementsAre("m", "m", "m", "", "", ""));
  EXPECT_THAT(units({.orientation = OrientationError::planar}), ElementsAre("m", "m", "rad"));
  EXPECT_THAT(units({.orientation = OrientationError::planar}, false), ElementsAre("m", "m"));
}

TEST(TrajectoryErrors, ComparesTheComponentsThatAreKept) {
  const Trajectory truth = each_second({{}});
  const TruthComparison planar(truth, {}, {.orientation = OrientationError::planar}, true);
  const PoseEstimate estimate{0.0, 42, {Vector3(1, 2, 3), yawed(0.5)}, diagonal_of({1, 2, 3, 4, 5, 6})};
  const UncertainPose zero{{}, 0.5 * PoseCovariance::Identity()};
  const std::vector<Index> y_and_yaw = {1, 4, 5}, z = {2};
  Step step;
  ASSERT_TRUE(planar.compare(estimate, zero, y_and_yaw, step));
  EXPECT_EQ(step.line, 42);
  EXPECT_THAT(step.states, ElementsAre(1, 2));
  EXPECT_LT((step.error - Eigen::Vector2d(2.0, 0.5)).norm(), 1e-15);
  EXPECT_EQ(step.P, Matrix(Eigen::Vector2d(2.5, 6.5).asDiagonal()));
  EXPECT_FALSE(planar.compare(estimate, zero, z, step)) << "no state of a plane";
}

TEST(TrajectoryErrors, CountsWhatHasNoTruthAndMeasuresTheWayOfTheTruth) {
  const Trajectory truth = each_second({{Vector3(0, 0, 0)}, {Vector3(3, 4, 0)}, {Vector3(3, 4, 2)}});
  Trajectory estimate = each_second({{}, {Vector3(4, 4, 0)}, {}, {}},
                                    std::vector<PoseCovariance>(4, PoseCovariance::Identity()));
  estimate.time_s[3] = 5.0;
  const TrajectoryErrors errors = trajectory_errors(estimate, truth, {});
  EXPECT_EQ(errors.unmatched, 1);
  EXPECT_THAT(errors.travelled_m, ElementsAre(0.0, 5.0, 7.0));
  ASSERT_EQ(errors.rows.size(), 3U);
  EXPECT_EQ(errors.rows[1].line, 11);
  EXPECT_EQ(errors.rows[1].error, Vector::Unit(6, 0)) << "estimate less truth";
  estimate.file = "estimate.txt";
  for (double& t : estimate.time_s) t += 10.0;
  EXPECT_THROW(trajectory_errors(estimate, truth, {}), DataError);
  EXPECT_THAT(
      no_truth(estimate.file, 10.0, 15.0, truth, {}).what(),
      HasSubstr("estimate.txt: no row has a truth at its time in : estimates from 10.000 to 15.000 s, "
                "truth from 0.000 to 2.000 s, tolerance 0.02 s"));
}

TEST(TrajectoryErrors, TimesInAnotherUnitAreToldWhereTheyWouldMeet) {
  const auto said = [](double estimate, double truth) {
    Trajectory moved = each_second({{}, {}, {}});
    for (double& t : moved.time_s) t = truth * (1.6e9 + t);
    const double first = estimate * 1.6e9, last = estimate * (1.6e9 + 2.0);
    return std::string(no_truth("estimate.txt", first, last, moved, {}).what());
  };
  EXPECT_THAT(said(1.0, 1e3), HasSubstr("; they would meet were the times of the truth in ms"));
  EXPECT_THAT(said(1.0, 1e9), HasSubstr("; they would meet were the times of the truth in ns"));
  EXPECT_THAT(said(1e6, 1.0), HasSubstr("; they would meet were the times of the estimates in µs"));
  EXPECT_THAT(said(1e9, 1e6), HasSubstr("; they would meet were the times of the estimates in ms"));
  EXPECT_THAT(said(1.0, 2.0), Not(HasSubstr("would meet")));
}

/// What is said of 500 estimates from 50 to 99.9 s, of which none meets a truth from `first_s` to `last_s`.
std::string said_of_truth(double first_s, double last_s, std::optional<double> time_offset_s = {}) {
  Trajectory truth = each_second({{}, {}, {}});
  truth.time_s = {first_s, 0.5 * (first_s + last_s), last_s};
  return no_truth("estimate.txt", 50.0, 99.9, truth, {.time_offset_s = time_offset_s}).what();
}

// In ms the truth would last 0.05 s, all of it among the estimates.
TEST(TrajectoryErrors, ATruthThatLastsAsLongHasAnotherZeroAndNoOtherUnit) {
  const std::string apart = said_of_truth(60000.0, 60049.9);
  EXPECT_THAT(apart, Not(HasSubstr("would meet")));
  EXPECT_THAT(apart, HasSubstr("clocks differ by about 59950 s (--time-offset 59950)"));
  EXPECT_THAT(said_of_truth(1.6e9 + 0.125, 1.6e9 + 48.0),
              HasSubstr("about 1599999950.125 s (--time-offset 1599999950.125)"));
  EXPECT_THAT(said_of_truth(-150.0, -101.0), HasSubstr("--time-offset -200)"));
  EXPECT_THAT(said_of_truth(60000.0, 60049.9, -59950.0), HasSubstr("--time-offset 59950)"))
      << "the sign was the other one";
  EXPECT_THAT(said_of_truth(60000.0, 60030.0), Not(HasSubstr("clocks"))) << "no drive of the same length";
}

TEST(TrajectoryErrors, OneRowIsAmongTheRowsOfTheTruthOrLastsUnlikeThem) {
  const Trajectory truth = each_second({{}, {}, {}});
  EXPECT_THAT(no_truth("estimate.txt", 0.5, 0.5, truth, {}).what(), HasSubstr("1 s apart"));
  EXPECT_THAT(no_truth("estimate.txt", 1e12 + 500.0, 1e12 + 500.0, truth, {}).what(),
              Not(HasSubstr("clocks")));
}

// The truth at t + offset, as the option takes it, is that of the estimate at t.
TEST(TrajectoryErrors, TheOffsetThatIsProposedBringsThemTogether) {
  Trajectory truth = each_second({{Vector3(0, 0, 0)}, {Vector3(4, 0, 0)}});
  for (double& t : truth.time_s) t += 60000.0;
  EXPECT_THAT(no_truth("estimate.txt", 50.0, 51.0, truth, {}).what(), HasSubstr("--time-offset 59950)"));
  const auto at = truth_at(truth, 50.25, {.max_time_difference_s = 1.0, .time_offset_s = 59950.0});
  ASSERT_TRUE(at.has_value());
  EXPECT_NEAR(at->pose.position.x(), 1.0, 1e-9);
}

TEST(TrajectoryErrors, APartOfTheTruthInAnotherUnitIsTold) {
  EXPECT_THAT(said_of_truth(60e3, 80e3), HasSubstr("they would meet were the times of the truth in ms"));
  EXPECT_THAT(said_of_truth(10e6, 3600e6), HasSubstr("they would meet were the times of the truth in µs"));
}

// Both begin at zero, and meet there alone.
TEST(TrajectoryErrors, TimesFromZeroInAnotherUnitAreTold) {
  const auto told = [](double last_s, double last_of_truth, std::int64_t unmatched) {
    Trajectory truth = each_second({{}, {}, {}});
    truth.time_s = {0.0, 0.5 * last_of_truth, last_of_truth};
    testing::RecordedSink sink;
    tell_unmatched(unmatched, 1000, 0.0, last_s, truth, {}, sink);
    return sink.said();
  };
  EXPECT_THAT(told(100.0, 1e5, 998),
              HasSubstr("Of 1000 rows 998 have no truth at their time; they would meet were the times of the "
                        "truth in ms."));
  EXPECT_THAT(told(1e11, 90.0, 999), HasSubstr("of the estimates in ns"));
  EXPECT_THAT(told(100.0, 1e5, 900), Not(HasSubstr("would meet"))) << "a tenth has one";
  EXPECT_THAT(told(100.0, 4e4, 998), Not(HasSubstr("would meet"))) << "a truth of 40 s in ms";
}

TEST(TrajectoryErrors, NoLogGoesBeyondTheYear5000) {
  EXPECT_EQ(no_seconds(4.1e9), "");
  EXPECT_THAT(no_seconds(1.7e12), HasSubstr("perhaps in ms"));
  EXPECT_THAT(no_seconds(1.7e15), HasSubstr("perhaps in µs"));
  EXPECT_THAT(no_seconds(1.7e18), HasSubstr("perhaps in ns"));
}

// Three quarters of the interval would take all but the rows in its middle, or these alone.
TEST(TrajectoryErrors, ATruthThatIsSlowerThanTheEstimateIsToldWithWhatTakesAllOfIt) {
  const Trajectory truth = each_second({{}, {}, {}});
  TrajectoryMatching matching;
  const auto said = [&] { return std::string(no_truth("estimate.txt", 0.1, 1.9, truth, matching).what()); };
  EXPECT_THAT(
      said(),
      HasSubstr("the rows of the truth are 1 s apart: --truth-time nearest takes the estimates beside "
                "one, --max-time-difference 1.1 takes what lies between two of them as well"));
  matching.truth_time = TruthTime::nearest;
  EXPECT_THAT(said(), HasSubstr("1 s apart: --max-time-difference 1.1 takes"));
  testing::RecordedSink many, few;
  tell_unmatched(25, 100, 0.1, 1.9, truth, matching, many);
  tell_unmatched(24, 100, 0.1, 1.9, truth, matching, few);
  EXPECT_EQ(many.unmatched_rows + few.unmatched_rows, 49);
  EXPECT_THAT(many.said(),
              HasSubstr("25 of 100 rows have no truth at their time; the rows of the truth are 1 s"));
  EXPECT_EQ(few.said(), "");
  matching.max_time_difference_s = 2.0;
  tell_unmatched(25, 100, 0.1, 1.9, truth, matching, few);
  EXPECT_EQ(few.said(), "") << "its rows are near enough";
}

}  // namespace
}  // namespace credence::internal
