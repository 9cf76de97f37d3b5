#include "datasets/logs/conventions/convention_check.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <random>

#include "core/manifold/angle.h"
#include "core/manifold/sek3.h"
#include "datasets/logs/conventions/reading_fit.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

constexpr double kSpacing = 0.1;

/// A log of a consistent filter: what it estimates, and the truth.
struct PoseLog {
  Trajectory estimate, truth;
};

SpatialPose true_pose(double t) {
  const Eigen::Quaterniond yaw(Eigen::AngleAxisd(0.31 * t, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond pitch(Eigen::AngleAxisd(0.7 * std::sin(0.23 * t), Eigen::Vector3d::UnitY()));
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(0.6 * std::cos(0.17 * t), Eigen::Vector3d::UnitX()));
  return {Eigen::Vector3d(20.0 * std::cos(0.1 * t), 15.0 * std::sin(0.13 * t) + 5.0, 2.0 + std::sin(0.2 * t)),
          yaw * pitch * roll};
}

/// Another covariance at every step, larger in some directions than in others.
PoseCovariance covariance_at(int i) {
  PoseError sigma;
  sigma << 0.10, 0.04, 0.06, 0.010, 0.004, 0.025;
  PoseCovariance C = PoseCovariance::Identity();
  C(0, 1) = C(1, 0) = 0.3;
  C(0, 5) = C(5, 0) = 0.4;
  C(3, 4) = C(4, 3) = -0.3;
  return (1.0 + 0.5 * std::sin(0.05 * i)) * (sigma.asDiagonal() * C * sigma.asDiagonal());
}

/// The pose with this error about the truth.
SpatialPose with_error(const SpatialPose& truth, const PoseError& e, PoseErrorAxes axes) {
  if (axes.position == PositionError::twist) {
    const SE3 T = SE3(SO3(truth.orientation), truth.position) * SE3::Exp(e);
    return {T.translation(), T.rotation().quaternion()};
  }
  SpatialPose pose;
  if (axes.orientation == OrientationError::rpy) {
    const Eigen::Vector3d angles = roll_pitch_yaw(truth.orientation) + e.tail<3>();
    pose.orientation = Eigen::AngleAxisd(angles[2], Eigen::Vector3d::UnitZ()) *
                       Eigen::AngleAxisd(angles[1], Eigen::Vector3d::UnitY()) *
                       Eigen::AngleAxisd(angles[0], Eigen::Vector3d::UnitX());
  } else {
    const Eigen::Quaterniond turn = SO3::Exp(e.tail<3>()).quaternion();
    pose.orientation =
        axes.orientation == OrientationError::world ? turn * truth.orientation : truth.orientation * turn;
  }
  pose.position = truth.position + (axes.position == PositionError::body
                                        ? Eigen::Vector3d(pose.orientation * Eigen::Vector3d(e.head<3>()))
                                        : Eigen::Vector3d(e.head<3>()));
  return pose;
}

/// Errors with covariance_at, correlated in time, in these axes.
PoseLog consistent_log(std::uint64_t seed, int rows, PoseErrorAxes axes, double correlation = 0.3) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  PoseLog log;
  PoseError white = PoseError::NullaryExpr([&] { return normal(random); });
  for (int i = -2; i < rows + 2; ++i) {
    const double t = kSpacing * i;
    log.truth.time_s.push_back(t);
    log.truth.lines.push_back(i + 3);
    log.truth.poses.push_back(true_pose(t));
    if (i < 0 || i >= rows) continue;
    const PoseError fresh = PoseError::NullaryExpr([&] { return normal(random); });
    white = correlation * white + std::sqrt(1.0 - correlation * correlation) * fresh;
    const PoseCovariance P = covariance_at(i);
    log.estimate.time_s.push_back(t);
    log.estimate.lines.push_back(i + 1);
    log.estimate.poses.push_back(with_error(true_pose(t), P.llt().matrixL() * white, axes));
    log.estimate.covariances.push_back(P);
  }
  return log;
}

/// What is said of a log that is read in a chart; "" for nothing.
std::string said(PoseLog log, const PoseChart& declared) {
  log.estimate.axes = declared.axes;
  for (PoseCovariance& P : log.estimate.covariances) P = declared.position_first(P);
  ConventionCheck check(declared, false);
  std::string text;
  testing::RecordedSink sink;
  trajectory_errors(log.estimate, log.truth, {}, &check, &sink);
  for (const std::string& sentence : sink.remarks) {
    if (sentence.starts_with("The covariance does not fit")) text += sentence;
  }
  return text;
}

struct Mistake {
  std::string name;
  std::string_view written;                 ///< the chart in which the filter's covariance holds
  std::function<void(PoseLog&)> make = {};  ///< what went wrong when the log was written
  std::string named;                        ///< what must be said of it
  std::string_view declared = "ros";
};

auto on_covariances(std::function<PoseCovariance(const PoseCovariance&)> change) {
  return [change](PoseLog& log) {
    for (PoseCovariance& P : log.estimate.covariances) P = change(P);
  };
}

auto scaled(double position, const Eigen::Vector3d& rotation) {
  PoseError d;
  d << Eigen::Vector3d::Constant(position), rotation;
  return on_covariances(
      [d](const PoseCovariance& P) -> PoseCovariance { return d.asDiagonal() * P * d.asDiagonal(); });
}

auto on_poses(Trajectory PoseLog::*which, std::function<SpatialPose(const SpatialPose&)> change) {
  return [=](PoseLog& log) {
    for (SpatialPose& pose : (log.*which).poses) pose = change(pose);
  };
}

PoseCovariance lower_triangle_read_as_upper(const PoseCovariance& P) {
  std::vector<double> numbers;
  for (Index i = 0; i < 6; ++i) {
    for (Index j = 0; j <= i; ++j) numbers.push_back(P(i, j));
  }
  PoseCovariance read;
  std::size_t next = 0;
  for (Index i = 0; i < 6; ++i) {
    for (Index j = i; j < 6; ++j) read(i, j) = read(j, i) = numbers[next++];
  }
  return read;
}

std::vector<Mistake> mistakes() {
  constexpr double kDegrees = 1.0 / kRadiansPerDegree;
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  const auto scalar_first = [](const SpatialPose& pose) {
    const Eigen::Quaterniond& q = pose.orientation;
    return SpatialPose{pose.position, Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y())};
  };
  const auto transposed = [](const SpatialPose& pose) {
    return SpatialPose{pose.position, pose.orientation.conjugate()};
  };
  const auto inverted = [](const SpatialPose& pose) {
    return SpatialPose{pose.orientation.conjugate() * -pose.position, pose.orientation.conjugate()};
  };
  const auto in_millimetres = [](const SpatialPose& pose) {
    return SpatialPose{1e3 * pose.position, pose.orientation};
  };
  const auto late = [](double samples) {
    return [samples](PoseLog& log) {
      for (double& t : log.estimate.time_s) t += samples * kSpacing;
    };
  };
  return {
      {"half angles", "ros", scaled(1.0, 0.5 * one), "chart ceres"},
      {"half angles in the body", "body", scaled(1.0, 0.5 * one), "half angles", "body"},
      {"whole angles for half ones", "ros", {}, "chart ros", "ceres"},
      {"rotation first", "ros",
       on_covariances([](const PoseCovariance& P) { return pose_chart_named("gtsam").position_first(P); }),
       "in the order rotation, position"},
      {"of GTSAM, pasted", "gtsam",
       on_covariances([](const PoseCovariance& P) { return pose_chart_named("gtsam").position_first(P); }),
       "chart gtsam"},
      {"degrees", "ros", scaled(1.0, kDegrees * one), "its rotation is in degrees"},
      {"degrees in one column", "ros", scaled(1.0, Eigen::Vector3d(1.0, 1.0, kDegrees)),
       "the third of its rotation angles is in degrees"},
      {"quaternion of the estimate w x y z", "ros", on_poses(&PoseLog::estimate, scalar_first),
       "quaternions of the estimate have the scalar first"},
      {"quaternion of the truth w x y z", "ros", on_poses(&PoseLog::truth, scalar_first),
       "quaternions of the truth have the scalar first"},
      {"transposed quaternion of the estimate", "ros", on_poses(&PoseLog::estimate, transposed),
       "quaternions of the estimate are transposed"},
      {"transposed quaternion of the truth", "ros", on_poses(&PoseLog::truth, transposed),
       "quaternions of the truth are transposed"},
      {"inverted poses of the estimate", "ros", on_poses(&PoseLog::estimate, inverted),
       "poses of the estimate are inverted"},
      {"truth in millimetres", "ros", on_poses(&PoseLog::truth, in_millimetres),
       "positions of the truth are in millimetres"},
      {"estimate in millimetres", "ros", on_poses(&PoseLog::estimate, in_millimetres),
       "positions of the estimate are in millimetres"},
      {"right for left error", "body", {}, "chart body"},
      {"left for right error", "ros", {}, "chart ros", "body"},
      {"roll, pitch and yaw", "rpy", {}, "chart rpy"},
      {"standard deviations", "ros", on_covariances([](const PoseCovariance& P) -> PoseCovariance {
         return P.unaryExpr([](double c) { return std::copysign(std::sqrt(std::abs(c)), c); });
       }),
       "standard deviations, not variances"},
      {"standard deviations on the diagonal of zeros", "ros",
       [](PoseLog& log) {
         // A filter without correlations: its errors are drawn again, from the diagonal.
         std::mt19937_64 random(5);
         std::normal_distribution<double> normal;
         for (std::size_t i = 0; i < log.estimate.poses.size(); ++i) {
           PoseCovariance& P = log.estimate.covariances[i];
           const PoseError sigma = P.diagonal().cwiseSqrt();
           const PoseError white = PoseError::NullaryExpr([&] { return normal(random); });
           log.estimate.poses[i] =
               with_error(true_pose(log.estimate.time_s[i]), sigma.cwiseProduct(white), kFixedAxes);
           P = sigma.asDiagonal();
         }
       },
       "standard deviations, not variances"},
      {"information matrix", "ros",
       on_covariances([](const PoseCovariance& P) -> PoseCovariance { return P.inverse(); }),
       "information matrix"},
      {"lower triangle", "ros", on_covariances(lower_triangle_read_as_upper), "lower triangle"},
      {"position in the body", "ros",
       [](PoseLog& log) {
         for (std::size_t i = 0; i < log.estimate.poses.size(); ++i) {
           PoseCovariance turn = PoseCovariance::Identity();
           turn.topLeftCorner<3, 3>() = log.estimate.poses[i].orientation.conjugate().toRotationMatrix();
           log.estimate.covariances[i] = turn * log.estimate.covariances[i] * turn.transpose();
         }
       },
       "its position is in the axes of the body"},
      {"millimetres", "ros", scaled(1e3, one), "its position is in millimetres"},
      {"north, east, down", "ros", on_covariances([](const PoseCovariance& P) -> PoseCovariance {
         const Eigen::PermutationMatrix<6> swap((Eigen::Matrix<int, 6, 1>() << 1, 0, 2, 4, 3, 5).finished());
         PoseError sign;
         sign << 1, 1, -1, 1, 1, -1;
         return sign.asDiagonal() * (swap * P * swap.transpose()) * sign.asDiagonal();
       }),
       "its axes are north, east, down"},
      {"a sample too late", "ros", late(1.0), "one sample, too late"},
      {"a sample too early", "ros", late(-1.0), "one sample, too early"},
  };
}

PoseErrorAxes axes_of(std::string_view chart) { return pose_chart_named(chart).axes; }

TEST(ConventionCheck, AMistakeIsNamedByItsCause) {
  constexpr int kRows = 600;
  for (const Mistake& mistake : mistakes()) {
    PoseLog log = consistent_log(7, kRows, axes_of(mistake.written));
    if (mistake.make) mistake.make(log);
    EXPECT_THAT(said(log, pose_chart_named(mistake.declared)), HasSubstr(mistake.named)) << mistake.name;
  }
}

// Between the rows of a truth of 100 Hz; at its ends estimates have none at the time that was meant.
TEST(ConventionCheck, TimesThatAreHalfASampleLateAreNamed) {
  for (const double late_s : {0.5 * kSpacing, -0.32 * kSpacing}) {
    PoseLog log = consistent_log(7, 600, kFixedAxes);
    log.truth = {};
    constexpr int kRows = 6000;
    for (int i = 0; i < kRows; ++i) {
      log.truth.time_s.push_back(0.01 * i);
      log.truth.lines.push_back(i + 1);
      log.truth.poses.push_back(true_pose(0.01 * i));
    }
    for (double& t : log.estimate.time_s) t += late_s;
    EXPECT_THAT(said(log, pose_chart_named("ros")),
                HasSubstr(late_s > 0.0 ? "times are 0.05 s too late (" : "times are 0.032 s too early ("));
  }
}

/// In the plane: z, roll and pitch have no variance. The truth has 100 Hz.
PoseLog planar_log(std::uint64_t seed, double late_s = 0.0) {
  constexpr int kRows = 600, kTruths = 6500;
  const auto true_at = [](double t) {
    return SpatialPose{{20.0 * std::cos(0.1 * t), 15.0 * std::sin(0.13 * t), 0.0},
                       Eigen::Quaterniond(Eigen::AngleAxisd(0.31 * t, Eigen::Vector3d::UnitZ()))};
  };
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  PoseLog log;
  for (int i = -100; i < kTruths; ++i) {
    log.truth.time_s.push_back(0.01 * i);
    log.truth.lines.push_back(i + 101);
    log.truth.poses.push_back(true_at(0.01 * i));
  }
  for (int i = 0; i < kRows; ++i) {
    PoseError sigma = PoseError::Zero(), e;
    sigma[0] = 0.1 + 0.05 * std::sin(0.05 * i);
    sigma[1] = 0.06;
    sigma[5] = 0.02;
    e = sigma.cwiseProduct(PoseError::NullaryExpr([&] { return normal(random); }));
    const SpatialPose truth = true_at(kSpacing * i - late_s);
    log.estimate.time_s.push_back(kSpacing * i);
    log.estimate.lines.push_back(i + 1);
    log.estimate.poses.push_back(with_error(truth, e, kFixedAxes));
    log.estimate.covariances.push_back(sigma.cwiseAbs2().asDiagonal());
  }
  return log;
}

TEST(ConventionCheck, AMistakeOfAPoseInThePlaneIsNamed) {
  const PoseChart& planar = pose_chart_named("planar");
  EXPECT_EQ(said(planar_log(1), planar), "");
  EXPECT_THAT(said(planar_log(2, 0.04), planar), HasSubstr("(chart planar, mean NEES "));
  EXPECT_THAT(said(planar_log(2, 0.04), planar), HasSubstr("the estimate's times are 0.04 s too late ("));
  const auto named = [&](const std::function<PoseCovariance(const PoseCovariance&)>& change) {
    PoseLog log = planar_log(3);
    on_covariances(change)(log);
    return said(std::move(log), planar);
  };
  EXPECT_THAT(named([](PoseCovariance P) {
                P(5, 5) /= kRadiansPerDegree * kRadiansPerDegree;
                return P;
              }),
              HasSubstr("its rotation is in degrees"));
  EXPECT_THAT(named([](const PoseCovariance& P) -> PoseCovariance { return P.cwiseSqrt(); }),
              HasSubstr("standard deviations, not variances"));
  EXPECT_THAT(named([](const PoseCovariance& P) -> PoseCovariance {
                return P.unaryExpr([](double variance) { return variance > 0.0 ? 1.0 / variance : 0.0; });
              }),
              HasSubstr("information matrix"));
}

TEST(ConventionCheck, NothingIsSaidOfLogsThatAreReadRightly) {
  constexpr int kLogs = 200, kRows = 300;
  int said_of = 0;
  for (int i = 0; i < kLogs; ++i) {
    const std::string_view chart = i % 2 == 0 ? "ros" : "body";
    const PoseLog log = consistent_log(static_cast<std::uint64_t>(1000 + i), kRows, axes_of(chart));
    said_of += said(log, pose_chart_named(chart)).empty() ? 0 : 1;
  }
  const double expected = ReadingFit::kLevel * kLogs;
  EXPECT_LE(said_of, expected + 5.0 * std::sqrt(expected));
}

TEST(ConventionCheck, AFilterThatIsWrongWithoutAMistakeIsNotExplainedAway) {
  PoseLog log = consistent_log(11, 600, kFixedAxes);
  for (PoseCovariance& P : log.estimate.covariances) P *= 0.4;
  EXPECT_EQ(said(log, pose_chart_named("ros")), "");
}

// A single drive whose errors stay for long passes no test of a mean; an orientation that is off by half a
// turn needs none.
TEST(ConventionCheck, WhatIsFarOffIsNamedAsNearlyFittingWhereNothingCanBeTested) {
  const PoseChart& body = pose_chart_named("body");
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    PoseLog log = consistent_log(seed, 300, body.axes, 0.995);
    for (SpatialPose& pose : log.estimate.poses) {
      const Eigen::Quaterniond q = pose.orientation;
      pose.orientation = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y());  // w x y z read as x y z w
    }
    EXPECT_THAT(said(log, body),
                HasSubstr("nearly would if the quaternions of the estimate have the scalar first"))
        << seed;
    PoseLog small = consistent_log(seed, 300, body.axes, 0.995);
    for (PoseCovariance& P : small.estimate.covariances) P *= 0.02;
    EXPECT_EQ(said(small, body), "") << seed;
  }
}

TEST(ConventionCheck, ALongLogIsThinnedAndStillNamed) {
  PoseLog log = consistent_log(12, 9000, kFixedAxes);
  scaled(1.0, Eigen::Vector3d::Constant(0.5))(log);
  EXPECT_THAT(said(log, pose_chart_named("ros")), HasSubstr("chart ceres"));
}

TEST(ConventionCheck, ChartsAreToldWhenAskedFor) {
  PoseLog log = consistent_log(13, 300, kFixedAxes);
  log.estimate.axes = kFixedAxes;
  ConventionCheck check(pose_chart_named("ros"), true);
  testing::RecordedSink sink;
  trajectory_errors(log.estimate, log.truth, {}, &check, &sink);
  const std::vector<std::string>& remarks = sink.remarks;
  ASSERT_EQ(remarks.size(), 1U);
  for (const PoseChart& chart : pose_charts()) {
    if (chart.axes.orientation == OrientationError::planar) continue;
    EXPECT_THAT(remarks[0], HasSubstr(std::string(chart.name) + " "));
  }
  EXPECT_THAT(remarks[0], HasSubstr("Judged is ros"));
  EXPECT_THAT(remarks[0], HasSubstr("carried over exactly"));
}

TEST(ConventionCheck, OfASingularCovarianceThereIsNoChartToBeCompared) {
  PoseLog log = consistent_log(13, 300, kFixedAxes);
  log.estimate.axes = kFixedAxes;
  for (PoseCovariance& P : log.estimate.covariances) {
    for (const Index i : {2, 3, 4}) {
      P.row(i).setZero();
      P.col(i).setZero();
    }
  }
  ConventionCheck check(pose_chart_named("ros"), true);
  testing::RecordedSink sink;
  trajectory_errors(log.estimate, log.truth, {}, &check, &sink);
  EXPECT_THAT(sink.remarks,
              ::testing::Contains("Charts cannot be compared: the covariance of the pose is singular."));
}

TEST(ReadingFit, OfErrorsWithTheirCovarianceAndWithAnother) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  constexpr std::size_t kRows = 1000;
  std::vector<Vector> errors;
  for (std::size_t i = 0; i < kRows; ++i)
    errors.push_back(Vector::NullaryExpr(2, [&] { return normal(random); }));
  const auto fit = [&](double first, double second) {
    return fit_reading(kRows, 2, {}, [&](std::size_t i, Vector& e, Matrix& P) {
      e = errors[i];
      P = Eigen::Vector2d(first, second).asDiagonal();
      return true;
    });
  };
  EXPECT_TRUE(fit(1.0, 1.0).fits());
  EXPECT_NEAR(fit(1.0, 1.0).nees, 2.0, 5.0 * std::sqrt(4.0 / kRows));
  EXPECT_TRUE(fit(4.0, 1.0).misfits());
  // Too large and too small in turn: the mean NEES of the whole does not see it.
  EXPECT_TRUE(fit(2.0, 2.0 / 3.0).misfits());
  EXPECT_GT(fit(1.0, 1.0).log_likelihood, fit(2.0, 2.0 / 3.0).log_likelihood);
  EXPECT_TRUE(fit(-1.0, 1.0).misfits());
}

// One error for all rows: no test of the mean can be made, and all rows are as small no more often than one
// is.
TEST(ReadingFit, WhatCouldNotBeTestedHasNotPassed) {
  const auto fit = [](double variance) {
    return fit_reading(1000, 1, {}, [&](std::size_t i, Vector& e, Matrix& P) {
      e = Vector::Constant(1, 1.0 + 1e-4 * static_cast<double>(i));
      P = Matrix::Constant(1, 1, variance);
      return true;
    });
  };
  EXPECT_FALSE(fit(1.0).all_tested);
  EXPECT_FALSE(fit(1.0).fits());
  EXPECT_FALSE(fit(1.0).misfits());
  EXPECT_TRUE(fit(1e-2).misfits());
  EXPECT_TRUE(fit(1e8).misfits());
}

}  // namespace
}  // namespace credence::internal
