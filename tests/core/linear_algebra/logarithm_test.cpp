#include "core/linear_algebra/logarithm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <random>

namespace credence::internal {
namespace {

using SixtyDigits = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>>;

TEST(NaturalLogarithm, is_within_one_ulp_of_60_digits) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> power(-1074.0, 1024.0), near(0.5, 2.0), close(-1e-3, 1e-3);
  double worst = 0.0;
  for (int i = 0; i < 4000; ++i) {
    for (const double x : {std::exp2(power(generator)), near(generator), 1.0 + close(generator)}) {
      if (x == 0.0 || std::isinf(x)) continue;
      const SixtyDigits exact = log(SixtyDigits(x));
      if (exact == 0) continue;
      int exponent;
      frexp(exact, &exponent);
      const auto off = static_cast<double>(abs(SixtyDigits(natural_logarithm(x)) - exact) /
                                           ldexp(SixtyDigits(1), exponent - 53));
      ASSERT_LE(off, 1.0) << std::hexfloat << x;
      worst = std::max(worst, off);
    }
  }
  EXPECT_GT(worst, 0.5);
}

TEST(NaturalLogarithm, special_values_are_those_of_the_standard) {
  constexpr double kLargest = std::numeric_limits<double>::infinity();
  EXPECT_EQ(natural_logarithm(1.0), 0.0);
  EXPECT_EQ(natural_logarithm(0.0), -kLargest);
  EXPECT_EQ(natural_logarithm(kLargest), kLargest);
  EXPECT_TRUE(std::isnan(natural_logarithm(-1.0)));
  EXPECT_TRUE(std::isnan(natural_logarithm(std::numeric_limits<double>::quiet_NaN())));
}

TEST(LogDeterminant, of_a_factor_is_twice_the_sum_of_logarithms) {
  Matrix L = Matrix::Identity(400, 400);
  double sum = 0.0;
  for (Index i = 0; i < L.rows(); ++i) {  // the product itself would be far out of range
    L(i, i) = std::ldexp(1.0 + 1e-3 * static_cast<double>(i), i < 300 ? 9 : -7);
    sum += 2.0 * std::log(L(i, i));
  }
  EXPECT_NEAR(log_determinant_of_factor(L), sum, 1e-13 * std::abs(sum));
  for (const Index i : {0, 1, 2, 3, 5, 398}) L(i, i) *= 1e-150;  // and far from the others
  EXPECT_NEAR(log_determinant_of_factor(L), sum - 12.0 * std::log(1e150), 1e-13 * std::abs(sum));
  EXPECT_EQ(log_determinant_of_factor(Matrix::Identity(3, 3)), 0.0);
  EXPECT_EQ(log_determinant_of_factor(Matrix(0, 0)), 0.0);
  L(7, 7) = -1.0;
  EXPECT_TRUE(std::isnan(log_determinant_of_factor(L)));
}

}  // namespace
}  // namespace credence::internal
