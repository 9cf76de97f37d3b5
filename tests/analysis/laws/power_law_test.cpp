#include "analysis/laws/power_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace credence::internal {
namespace {

TEST(PowerLaw, IsExactOnAPowerLaw) {
  const std::vector<double> x{10, 100, 1000}, y{5e2, 5e4, 5e6};
  const PowerLaw law = fit_power_law(x, y);
  EXPECT_NEAR(law.exponent, 2.0, 1e-13);
  EXPECT_NEAR(law.upper - law.lower, 0.0, 1e-6);
}

// Worked by hand: log10 y = 0, 1, 1 at log10 x = 0, 1, 2 has slope 1/2 and residual sum of squares 1/6;
// the slope's standard error is sqrt(1/6 / 1 / 2), and t of one degree of freedom at 97.5 % is 12.7062047.
TEST(PowerLaw, HasTheIntervalOfALine) {
  const std::vector<double> x{1, 10, 100}, y{1, 10, 10};
  const PowerLaw law = fit_power_law(x, y);
  EXPECT_NEAR(law.exponent, 0.5, 1e-14);
  EXPECT_NEAR(law.upper - law.exponent, 12.7062047362 * std::sqrt(1.0 / 12.0), 1e-8);
  EXPECT_NEAR(law.exponent - law.lower, law.upper - law.exponent, 1e-12);
}

TEST(PowerLaw, OfTwoPointsHasNoInterval) {
  const std::vector<double> x{1, 2}, y{3, 12};
  const PowerLaw law = fit_power_law(x, y);
  EXPECT_NEAR(law.exponent, 2.0, 1e-14);
  EXPECT_TRUE(std::isnan(law.lower) && std::isnan(law.upper));
}

TEST(PowerLaw, RefusesWhatHasNone) {
  const std::vector<double> one{1}, same{2, 2}, two{1, 2}, zero{0, 1};
  EXPECT_THROW(fit_power_law(one, one), std::invalid_argument);
  EXPECT_THROW(fit_power_law(same, two), std::invalid_argument);
  EXPECT_THROW(fit_power_law(two, zero), std::invalid_argument);
  EXPECT_THROW(fit_power_law(two, one), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
