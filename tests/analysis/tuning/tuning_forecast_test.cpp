#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "analysis/tuning/tuning.h"
#include "tests/analysis/tuning/quadratic_score.h"

namespace credence::internal {
namespace {

using testing::QuadraticScore;
using testing::some_curvature;

TuningForecast forecast_of(const Matrix& information, double steps = 1.0) {
  const Index p = information.rows();
  return forecast_tuning(QuadraticScore(Vector::Zero(p), information), Vector::Zero(p), steps);
}

std::int64_t count_identifiable(const TuningForecast& forecast) {
  return std::ranges::count(forecast.parameters, true, &TuningForecast::Parameter::identifiable);
}

TEST(TuningForecast, IsTheBoundOfCramerAndRao) {
  const TuningForecast forecast = forecast_of(some_curvature(), 500.0);
  const Matrix covariance = some_curvature().inverse();
  ASSERT_EQ(forecast.parameters.size(), 3U);
  for (Index i = 0; i < 3; ++i) {
    const TuningForecast::Parameter& parameter = forecast.parameters[static_cast<std::size_t>(i)];
    EXPECT_TRUE(parameter.identifiable);
    EXPECT_TRUE(parameter.reason.empty());
    EXPECT_NEAR(parameter.relative_error, std::sqrt(covariance(i, i)), 1e-12);
    // With as many steps the variance is 0.01.
    EXPECT_NEAR(covariance(i, i) * 500.0 / parameter.steps_for_10_percent, 0.01, 1e-14);
  }
  EXPECT_EQ(forecast.parameters[1].name, "b");
  EXPECT_EQ(forecast.steps, 500.0);
}

TEST(TuningForecast, HoldsWhatHasNoEffect) {
  Matrix information = some_curvature();
  information.row(1).setZero();
  information.col(1).setZero();
  const TuningForecast forecast = forecast_of(information);
  EXPECT_EQ(count_identifiable(forecast), 2);
  EXPECT_FALSE(forecast.parameters[1].identifiable);
  EXPECT_EQ(forecast.parameters[1].reason, "it has no effect on the innovations");
  EXPECT_TRUE(std::isnan(forecast.parameters[1].relative_error));
  EXPECT_EQ(count_identifiable(forecast_of(Matrix::Zero(2, 2))), 0);
}

TEST(TuningForecast, HoldsOneOfACombination) {
  // The third direction is the sum of the others; units of very different size do not matter.
  Matrix B(3, 2);
  B << 1.0, 0.0, 0.3, 1.0, 1.3, 1.0;
  for (const double unit : {1.0, 1e-6, 1e6}) {
    const Vector units{{1.0, unit, 1.0}};
    const TuningForecast forecast = forecast_of(units.asDiagonal() * B * B.transpose() * units.asDiagonal());
    EXPECT_EQ(count_identifiable(forecast), 2) << unit;
    const auto held = std::ranges::find(forecast.parameters, false, &TuningForecast::Parameter::identifiable);
    EXPECT_EQ(held->reason, "it cannot be told from a combination of the others");
  }
}

TEST(TuningForecast, KnowsWhatIsNearlyACombinationButIsNot) {
  for (const double share : {1e-4, 1e-7}) {
    Matrix information(2, 2);
    const double r = std::sqrt(1.0 - share);
    information << 1.0, r, r, 1.0;
    const TuningForecast forecast = forecast_of(information);
    EXPECT_EQ(count_identifiable(forecast), 2) << share;
    EXPECT_NEAR(forecast.parameters[0].relative_error * std::sqrt(share), 1.0, 1e-6) << share;
  }
}

TEST(TuningForecast, WithoutInformationHoldsNothing) {
  class Unknown : public QuadraticScore {
   public:
    using QuadraticScore::QuadraticScore;
    Matrix expected_information(const Vector& /*phi*/) const override { return {}; }
  };
  const TuningForecast forecast =
      forecast_tuning(Unknown(Vector::Zero(3), some_curvature()), Vector::Zero(3), 1.0);
  EXPECT_EQ(count_identifiable(forecast), 3);
  EXPECT_TRUE(std::isnan(forecast.parameters[0].relative_error));
}

TEST(TuningForecast, HoldsTheOneOfLessInformation) {
  // The same direction of two units: 1 and 100 times the slope.
  for (const Vector& slope : {Vector{{0.01, 1.0}}, Vector{{1.0, 0.01}}}) {
    const QuadraticScore score(Vector::Zero(2), slope * slope.transpose());
    const TuningForecast forecast = forecast_tuning(score, Vector::Zero(2), 1.0);
    for (Index i = 0; i < 2; ++i) {
      EXPECT_EQ(forecast.parameters[static_cast<std::size_t>(i)].identifiable, slope[i] == 1.0);
    }
  }
}

}  // namespace
}  // namespace credence::internal
