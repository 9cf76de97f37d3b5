#include "core/simd/fused_multiply_add.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace credence::internal {
namespace {

void expect_same(double a, double b, double c) {
  const double got = software_fma(a, b, c), exact = std::fma(a, b, c);
  if (std::isnan(exact)) {
    ASSERT_TRUE(std::isnan(got));
  } else {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(got), std::bit_cast<std::uint64_t>(exact))
        << std::hexfloat << a << " " << b << " " << c;
  }
}

TEST(SoftwareFma, has_the_bits_of_the_instruction) {
  std::mt19937_64 generator(20040928);
  std::uniform_real_distribution<double> number(-2.0, 2.0), power(-120.0, 120.0), far(-1070.0, 1020.0);
  for (int i = 0; i < 300000; ++i) {
    const double a = number(generator), b = number(generator);
    expect_same(a, b, number(generator));
    expect_same(a, b, number(generator) * std::exp2(power(generator)));
    expect_same(a, b, -(a * b));                       // the error of a product
    expect_same(a, b, std::nextafter(-(a * b), 3.0));  // cancellation to a few bits
    expect_same(a * std::exp2(far(generator)), b, number(generator) * std::exp2(far(generator)));
    expect_same(a * std::exp2(far(generator)), b * std::exp2(far(generator)), number(generator));
  }
}

// Products that lie next to the middle of two doubles of c: the case that two roundings get wrong.
TEST(SoftwareFma, rounds_once_next_to_the_middle) {
  std::mt19937_64 generator(5);
  bool differs = false;
  for (int i = 0; i < 300000; ++i) {
    const double c = 1.0 + std::ldexp(static_cast<double>(generator() >> 12), -52);
    for (const double tiny : {0x1p-53, -0x1p-54, 0x1p-52}) {
      const double a = 1.0 + std::ldexp(static_cast<double>(generator() & 255), -52);
      const double b = tiny * (1.0 - std::ldexp(static_cast<double>(generator() & 255), -53));
      expect_same(a, b, c);
      differs = differs || a * b + c != std::fma(a, b, c);
    }
  }
  EXPECT_TRUE(differs);
}

TEST(SoftwareFma, special_values_are_those_of_the_standard) {
  constexpr double kLargest = std::numeric_limits<double>::max(),
                   kInfinity = std::numeric_limits<double>::infinity();
  const std::vector<double> values{0.0,      -0.0,      1.0,       -1.5,       0x1p-1074,   -0x1p-1022,
                                   kLargest, -kLargest, kInfinity, -kInfinity, std::nan("")};
  for (const double a : values) {
    for (const double b : values) {
      for (const double c : values) expect_same(a, b, c);
    }
  }
}

}  // namespace
}  // namespace credence::internal
