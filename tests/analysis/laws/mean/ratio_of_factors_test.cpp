#include "analysis/laws/mean/ratio_of_factors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "analysis/laws/normal_quantile.h"

namespace credence::internal {
namespace {

/// Log-normal with this standard error, its interval at 90 %.
FactorInterval log_normal(double factor, double standard_error) {
  const double z = normal_quantile_two_sided(0.9);
  return {factor, factor * std::exp(-z * standard_error), factor * std::exp(z * standard_error), z};
}

// The logarithm of the ratio of two log-normal factors is normal, its variance the sum of theirs: 0.3² + 0.4²
// = 0.5².
TEST(RatioOfFactors, OfLogNormalFactorsIsExact) {
  const RatioOfFactors r = ratio_of_factors(log_normal(3.0, 0.3), log_normal(2.0, 0.4), 0.95);
  const double step = std::log(1.5), z = normal_quantile_two_sided(0.95);
  EXPECT_NEAR(r.ratio.mean, 1.5, 1e-12);
  EXPECT_NEAR(r.ratio.lower, std::exp(step - 0.5 * z), 1e-12);
  EXPECT_NEAR(r.ratio.upper, std::exp(step + 0.5 * z), 1e-12);
  EXPECT_NEAR(r.p_value, std::erfc(step / 0.5 / std::sqrt(2.0)), 1e-12);
  EXPECT_NEAR(ratio_of_factors(log_normal(2.0, 0.4), log_normal(3.0, 0.3), 0.95).p_value, r.p_value, 1e-12);
}

// A second that is larger is compared by its own lower end and the upper one of the first.
TEST(RatioOfFactors, TakesTheEndsThatFaceEachOther) {
  const double z = normal_quantile_two_sided(0.95);
  const FactorInterval first{1.0, 0.01, 1.5, z}, second{2.0, 1.6, 200.0, z};
  const double down = std::hypot(std::log(2.0 / 1.6), std::log(1.5)) / z;
  const RatioOfFactors r = ratio_of_factors(second, first, 0.95);
  EXPECT_NEAR(r.p_value, std::erfc(std::log(2.0) / down / std::sqrt(2.0)), 1e-12);
  EXPECT_NEAR(r.ratio.lower, 2.0 * std::exp(-z * down), 1e-12);
}

// The logarithm of the product of 3 and 1/2 is that of the ratio of 3 to 2.
TEST(RatioOfFactors, TheMiddleIsThatOfTheProduct) {
  EXPECT_NEAR(p_value_of_middle(log_normal(3.0, 0.3), log_normal(0.5, 0.4)),
              ratio_of_factors(log_normal(3.0, 0.3), log_normal(2.0, 0.4), 0.95).p_value, 1e-12);
  EXPECT_NEAR(p_value_of_middle(log_normal(2.0, 0.3), log_normal(0.5, 0.4)), 1.0, 1e-12);
}

TEST(RatioOfFactors, OfEqualOnesWithoutWidthSaysNothing) {
  const FactorInterval one{1.0, 1.0, 1.0, 2.0};
  EXPECT_EQ(ratio_of_factors(one, one, 0.95).p_value, 1.0);
  EXPECT_TRUE(one.is_known());
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_FALSE((FactorInterval{1.0, 0.0, 2.0, 2.0}.is_known()));
  EXPECT_FALSE((FactorInterval{1.0, 0.5, kInfinity, 2.0}.is_known()));
  EXPECT_FALSE((FactorInterval{std::nan(""), std::nan(""), std::nan(""), 2.0}.is_known()));
}

}  // namespace
}  // namespace credence::internal
