#include "core/manifold/trigonometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/simd/trigonometry_kernel.h"

namespace credence::internal {
namespace {

using Digits60 = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

double ulps_off(double got, const Digits60& exact) {
  if (exact == 0) return got == 0.0 ? 0.0 : 1e300;
  int exponent;
  frexp(exact, &exponent);
  return static_cast<double>(abs(Digits60(got) - exact) / ldexp(Digits60(1), exponent - 53));
}

/// Angles of every size up to the largest, ends of the octants, and doubles next to multiples of π/2.
std::vector<double> angles(int count) {
  std::mt19937_64 generator(20040928);
  std::uniform_real_distribution<double> turn(-4.0, 4.0), power(-40.0, 20.0), wide(-0x1p20, 0x1p20);
  std::vector<double> x{0.0, -0.0, 0x1p-1074, 1e-300, 0x1p-27, 0x1p20, -0x1p20};
  for (int k = 1; k < 2000; k += 1 + k / 16) {
    for (const double at : {0.25, 0.5}) {
      const double edge = k * at * std::numbers::pi;
      for (const double a : {edge, std::nextafter(edge, 0.0), std::nextafter(edge, 1e9)}) x.push_back(a);
    }
  }
  for (int i = 0; i < count; ++i) {
    x.push_back(turn(generator));
    x.push_back(std::exp2(power(generator)));
    x.push_back(wide(generator));
  }
  return x;
}

struct Sides {
  std::vector<double> y, x;
};

/// All octants, all sizes, their borders, and what takes the long way.
Sides sides(int count) {
  Sides s;
  const std::vector<double> special{0.0,       -0.0,    1.0,     -1.0,    0.5,       -2.0,
                                    0x1p-1074, -0x1p-1, 1e308,   1e-308,  kInfinity, -kInfinity,
                                    0x1p-500,  0x1p500, 0x1p501, -1e-200, 3e-310,    1e-18};
  for (const double y : special) {
    for (const double x : special) {
      s.y.push_back(y);
      s.x.push_back(x);
    }
  }
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0), power(-30.0, 30.0);
  for (int i = 0; i < count; ++i) {
    const double x = any(generator), y = any(generator);
    s.y.insert(s.y.end(), {y, y * std::exp2(power(generator)), std::nextafter(0.5 * x, 9.0), x, 0.5 * x});
    s.x.insert(s.x.end(), {x, x, x, std::nextafter(x, -9.0), x});
  }
  return s;
}

TEST(Trigonometry, sine_and_cosine_are_within_one_ulp_of_60_digits) {
  double worst = 0.0;
  for (const double x : angles(3000)) {
    const SineCosine got = sine_cosine(x);
    const double s = ulps_off(got.sine, sin(Digits60(x))), c = ulps_off(got.cosine, cos(Digits60(x)));
    ASSERT_LE(s, 1.0) << std::hexfloat << x;
    ASSERT_LE(c, 1.0) << std::hexfloat << x;
    worst = std::max({worst, s, c});
  }
  RecordProperty("largest_error_ulp", std::to_string(worst));
  EXPECT_GT(worst, 0.5);  // nothing is correctly rounded for free
}

TEST(Trigonometry, arc_tangent_is_within_one_ulp_of_60_digits) {
  double worst = 0.0;
  const Sides s = sides(3000);
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    if (std::isinf(s.x[i]) || std::isinf(s.y[i]) || (s.x[i] == 0.0 && s.y[i] == 0.0)) continue;
    const Digits60 exact = atan2(Digits60(s.y[i]), Digits60(s.x[i]));
    const double got = arc_tangent(s.y[i], s.x[i]);
    if (abs(exact) < Digits60(1e-300)) {  // of subnormal numbers the ulp is that of the smallest
      ASSERT_EQ(got, std::atan2(s.y[i], s.x[i]));
      continue;
    }
    // an exact zero has a sign that 60 digits do not have
    const double off = s.y[i] == 0.0 ? ulps_off(std::abs(got), abs(exact)) : ulps_off(got, exact);
    ASSERT_LE(off, 1.0) << std::hexfloat << s.y[i] << " " << s.x[i];
    worst = std::max(worst, off);
  }
  RecordProperty("largest_error_ulp", std::to_string(worst));
  EXPECT_GT(worst, 0.5);
}

TEST(Trigonometry, special_values_are_those_of_the_standard) {
  const std::vector<double> special{0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity};
  for (const double y : special) {
    for (const double x : special) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(arc_tangent(y, x)),
                std::bit_cast<std::uint64_t>(std::atan2(y, x)))
          << y << " " << x;
    }
    EXPECT_TRUE(std::isnan(arc_tangent(y, kNoNumber)));
    EXPECT_TRUE(std::isnan(arc_tangent(kNoNumber, y)));
  }
  for (const double x : {kInfinity, -kInfinity, kNoNumber}) {
    EXPECT_TRUE(std::isnan(sine(x)));
    EXPECT_TRUE(std::isnan(cosine(x)));
  }
  EXPECT_EQ(sine(-0.0), 0.0);
  EXPECT_EQ(arc_sine(1.0), std::asin(1.0));
  EXPECT_NEAR(arc_sine(-0.3), std::asin(-0.3), 1e-16);
  EXPECT_TRUE(std::isnan(arc_sine(1.5)));
}

TEST(Trigonometry, large_angles_are_taken_modulo_a_turn) {
  for (const double x : {1.5e6, -4e9, 1e15}) {
    const SineCosine got = sine_cosine(x);
    const double ulp = std::nextafter(std::abs(x), kInfinity) - std::abs(x);
    EXPECT_NEAR(got.sine, std::sin(x), ulp);
    EXPECT_NEAR(got.cosine, std::cos(x), ulp);
  }
}

TEST(Trigonometry, every_width_gives_the_bits_of_width_one) {
  Sides s = sides(3001);
  s.y[40] = kNoNumber;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    const TrigonometryKernel& kernel = trigonometry_kernel(set);
    std::vector<double> out(s.x.size());
    arc_tangents_by(kernel, s.y.data(), s.x.data(), out.data(), out.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(out[i]),
                std::bit_cast<std::uint64_t>(arc_tangent(s.y[i], s.x[i])))
          << instruction_set_name(set) << std::hexfloat << " " << s.y[i] << " " << s.x[i];
    }
  }
}

}  // namespace
}  // namespace credence::internal
