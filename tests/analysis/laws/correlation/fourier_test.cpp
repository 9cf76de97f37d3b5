#include "analysis/laws/correlation/fourier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace credence::internal {
namespace {

TEST(Fourier, IsTheSumOfItsDefinition) {
  const std::vector<double> u = {1.0, -2.0, 0.5, 3.0, 0.25, -1.5};
  const auto waves = fourier(u);
  const std::vector<double> powers = periodogram(u);
  ASSERT_EQ(waves.size(), u.size());
  ASSERT_EQ(powers.size(), 2U);  // of j = 1, 2; j = 3 is N/2
  for (std::size_t j = 0; j < u.size(); ++j) {
    std::complex<double> sum;
    for (std::size_t k = 0; k < u.size(); ++k)
      sum += u[k] * std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(j * k) / 6.0);
    EXPECT_NEAR(std::abs(waves[j] - sum), 0.0, 1e-13) << j;
    if (j == 1 || j == 2) {
      EXPECT_NEAR(powers[j - 1], std::norm(sum), 1e-12) << j;
    }
  }
}

TEST(Fourier, LengthsArePowersOfSmallPrimes) {
  EXPECT_EQ(quick_length(1), 1U);
  EXPECT_EQ(quick_length(7), 6U);
  EXPECT_EQ(quick_length(2000), 2000U);
  EXPECT_EQ(quick_length(2017), 2000U);
}

}  // namespace
}  // namespace credence::internal
