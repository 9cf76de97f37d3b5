#include "datasets/logs/conventions/pose_readings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

namespace credence::internal {
namespace {

/// The reading whose cause has these words in it.
PoseReading reading_that(std::string_view words, const PoseChart& declared) {
  for (const PoseReading& reading : mistaken_readings(declared)) {
    if (reading.cause.find(words) != std::string::npos) return reading;
  }
  throw std::logic_error("no reading of " + std::string(words));
}

/// The covariance that such a reading of the chart "ros" takes `written` for.
PoseCovariance covariance_read(std::string_view words, const PoseCovariance& written) {
  PoseSample sample;
  sample.written = written;
  PoseError error;
  PoseCovariance P;
  EXPECT_TRUE(reading_that(words, pose_chart_named("ros")).read(sample, error, P)) << words;
  return P;
}

/// 1 … 21 along the upper triangle by rows.
PoseCovariance counted() {
  PoseCovariance C;
  double next = 0.0;
  for (Index i = 0; i < 6; ++i) {
    for (Index j = i; j < 6; ++j) C(i, j) = C(j, i) = ++next;
  }
  return C;
}

TEST(PoseReadings, RepairTheNumbersOfACovariance) {
  const PoseCovariance C = counted();
  const double degree = std::numbers::pi / 180.0;
  EXPECT_EQ(covariance_read("standard deviations", -C)(1, 4), -100.0) << "squares keep their sign";
  EXPECT_DOUBLE_EQ(covariance_read("in centimetres", C)(0, 0), 1e-4);
  EXPECT_DOUBLE_EQ(covariance_read("in millimetres", C)(0, 5), 6e-3);
  EXPECT_DOUBLE_EQ(covariance_read("the second of its rotation", C)(4, 4), 19.0 * degree * degree);
  EXPECT_DOUBLE_EQ(covariance_read("the second of its rotation", C)(4, 5), 20.0 * degree);
  const PoseCovariance lower = covariance_read("lower triangle", C);
  EXPECT_EQ(lower(1, 1), 3.0);
  EXPECT_EQ(lower(3, 5), 19.0) << "1 + … + 5 numbers are above its row, and three before it";
  // East takes the place of north; down is −up.
  const PoseCovariance enu = covariance_read("north, east, down", C);
  EXPECT_EQ(enu(0, 0), C(1, 1));
  EXPECT_EQ(enu(0, 2), -C(1, 2));
  EXPECT_EQ(enu(2, 5), C(2, 5));
}

TEST(PoseReadings, AnInformationMatrixIsInvertedUnlessItIsNone) {
  const PoseCovariance A = counted() + 100.0 * PoseCovariance::Identity();
  EXPECT_LT((covariance_read("information matrix", A) * A - PoseCovariance::Identity()).norm(), 1e-13);
  PoseSample singular;
  PoseError error;
  PoseCovariance P;
  EXPECT_FALSE(
      reading_that("information matrix", pose_chart_named("ros")).read(singular, error, P));  // of zeros
}

// A turn by φ about z has the quaternion (0, 0, sin φ/2; cos φ/2), and the half vector φ/2.
TEST(PoseReadings, ErrorsAndCovariancesOfHalfAnglesAreToldInWholeOnes) {
  PoseSample sample;
  sample.estimate.orientation = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ());
  sample.written = counted();
  sample.truth_covariance = 3.0 * PoseCovariance::Identity();
  PoseError error;
  PoseCovariance P;
  ASSERT_TRUE(
      (PoseReading{.cause = "", .repair = "", .chart = pose_chart_named("ceres")}.read(sample, error, P)));
  EXPECT_NEAR(error[5], 0.6, 1e-15);
  EXPECT_DOUBLE_EQ(P(0, 0), 1.0 + 3.0);
  EXPECT_DOUBLE_EQ(P(0, 5), 2.0 * 6.0);
  EXPECT_DOUBLE_EQ(P(5, 5), 4.0 * 21.0 + 3.0) << "that of the truth is of whole angles already";
}

// A turn of 1 rad: g2o writes the vector part of its quaternion, Ceres half of its vector.
TEST(PoseReadings, HalfAnglesAreReadAsRadiansToFirstOrder) {
  PoseSample sample;
  sample.estimate.orientation = Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitY());
  sample.written = PoseCovariance::Identity();
  for (const auto& [name, rotation] :
       {std::pair("g2o", 2.0 * std::sin(0.5)), {"ceres", 1.0}, {"gtsam", 1.0}}) {
    const PoseReading reading{"", "", pose_chart_named(name)};
    PoseError error;
    PoseCovariance P;
    ASSERT_TRUE(reading.read(sample, error, P));
    EXPECT_NEAR(error[4], rotation, 1e-15) << name;
    EXPECT_EQ(P(4, 4), name == std::string("gtsam") ? 1.0 : 4.0) << name;
  }
}

TEST(PoseReadings, TryEveryOtherChartOnce) {
  for (const PoseChart& declared : pose_charts()) {
    std::vector<std::pair<PoseErrorAxes, bool>> tried;
    for (const PoseReading& reading : mistaken_readings(declared)) {
      EXPECT_FALSE(reading.cause.empty() || reading.repair.empty());
      const std::pair chart(reading.chart.axes, reading.chart.rotation_first);
      const bool is_declared = chart == std::pair(declared.axes, declared.rotation_first);
      EXPECT_EQ(is_declared, reading.change != nullptr) << declared.name << ": " << reading.cause;
      if (is_declared) continue;
      EXPECT_EQ(std::ranges::count(tried, chart), 0) << declared.name << ": " << reading.cause;
      tried.push_back(chart);
    }
    if (declared.axes.orientation == OrientationError::planar) {
      EXPECT_EQ(tried.size(), 0U);
    } else {
      EXPECT_GE(tried.size(), 7U);
    }
  }
}

}  // namespace
}  // namespace credence::internal
