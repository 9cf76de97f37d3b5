#include "montecarlo/random/normal_kernel.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

namespace credence::internal {
namespace {

using Reference = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>>;

constexpr std::array kAllSets{InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512};

std::vector<InstructionSet> sets_with_normals() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : kAllSets) {
    if (is_supported(set)) sets.push_back(set);
  }
  return sets;
}

std::vector<double> pairs(InstructionSet set, std::vector<std::uint64_t> bits) {
  bits.resize((bits.size() + kNoiseLanes - 1) / kNoiseLanes * kNoiseLanes);
  std::vector<double> out(2 * bits.size());
  normal_kernel(set).pairs(bits.data(), static_cast<std::int64_t>(bits.size()) / kNoiseLanes, out.data());
  return out;
}

/// The pair of one word of bits, at index `i` of what pairs() returned.
std::pair<double, double> pair_of(const std::vector<double>& out, std::size_t i) {
  const std::size_t half = i / kNoiseLanes, lane = i % kNoiseLanes;
  return {out[2 * half * kNoiseLanes + lane], out[(2 * half + 1) * kNoiseLanes + lane]};
}

/// The pair as montecarlo/random/noise.h defines it, byte by byte, with 60 digits.
std::pair<Reference, Reference> exact_pair(std::uint64_t bits) {
  const auto byte = [&](int i) { return (bits >> (8 * i)) & 0xff; };
  const std::uint64_t b0 = byte(0);
  std::uint64_t angle = b0 & 15;
  for (int i = 1; i <= 6; ++i) angle = (angle << 8) | byte(i);
  const Reference two_to_52 = std::ldexp(1.0, 52);
  const Reference u = (Reference(bits >> 12) + Reference(0.5)) / two_to_52;
  const Reference v = Reference(angle) / two_to_52 - Reference(0.5);
  const Reference r = sqrt(-2 * log(u));
  const Reference turn = boost::math::constants::pi<Reference>() * v / 2;
  const Reference sine = r * sin(turn);
  const Reference cosine = (b0 & 0x80) ? Reference(-r * cos(turn)) : Reference(r * cos(turn));
  return (b0 & 0x40) ? std::pair{sine, cosine} : std::pair{cosine, sine};
}

double ulps(double got, const Reference& exact) {
  if (exact == 0) return got == 0.0 ? 0.0 : 1e300;
  int exponent;
  frexp(exact, &exponent);
  return static_cast<double>(abs(Reference(got) - exact) / ldexp(Reference(1), exponent - 53));
}

/// Where the pieces of the algorithm meet: ends of the intervals of the logarithm, of the angle, of the
/// tails.
std::vector<std::uint64_t> edge_bits() {
  std::vector<std::uint64_t> bits{0,     ~std::uint64_t{0}, 0x8000000000000000, 0x7fffffffffffffff,
                                  0xfff, 0xffffff};
  for (int k = 1; k < 64; ++k) {
    const double edge = k / 64.0;
    const auto u = static_cast<std::uint64_t>(std::ldexp(edge, 52));
    for (std::uint64_t d : {std::uint64_t{0}, std::uint64_t{1}, ~std::uint64_t{0}}) {
      bits.push_back((u + d) << 12 | 0x5a5);
    }
  }
  for (int k = 12; k < 64; ++k) {
    bits.push_back(std::uint64_t{1} << k);
    bits.push_back(~(std::uint64_t{1} << k));
    bits.push_back((~std::uint64_t{0}) << k);
    bits.push_back(~((~std::uint64_t{0}) << k));
  }
  for (std::uint64_t low = 0; low < 256; ++low) bits.push_back(0x3243f6a8885a3000 | low);
  for (std::uint64_t b1 = 0; b1 < 256; ++b1) bits.push_back(0x0000000000000008 | b1 << 8);
  return bits;
}

std::vector<std::uint64_t> random_bits(std::size_t count) {
  std::mt19937_64 generator(20040928);
  std::vector<std::uint64_t> bits(count);
  for (std::uint64_t& b : bits) b = generator();
  // a quarter of them in the tails, where the radius is large
  for (std::size_t i = 0; i < count; i += 4) bits[i] >>= 1 + i % 50;
  return bits;
}

// Known answers of Random123 1.14, kat_vectors, "philox4x32 10".
TEST(NormalKernel, philox_gives_the_known_answers) {
  struct Known {
    std::uint32_t counter[4], key[2], out[4];
  };
  const Known known[] = {
      {{0, 0, 0, 0}, {0, 0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
      {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
       {0xffffffff, 0xffffffff},
       {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
      {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
       {0xa4093822, 0x299f31d0},
       {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}},
  };
  for (const InstructionSet set : sets_with_normals()) {
    for (const Known& k : known) {
      const NoiseBlockKey key{.key = std::uint64_t{k.key[1]} << 32 | k.key[0],
                              .run = std::uint64_t{k.counter[3]} << 32 | k.counter[0],
                              .word1 = k.counter[1],
                              .purpose = k.counter[2]};
      std::uint64_t out[2];
      normal_kernel(set).bits(key, 0, out, 1);
      EXPECT_EQ(out[0], std::uint64_t{k.out[0]} << 32 | k.out[1]) << instruction_set_name(set);
      EXPECT_EQ(out[1], std::uint64_t{k.out[2]} << 32 | k.out[3]) << instruction_set_name(set);
    }
  }
}

TEST(NormalKernel, bits_and_normals_of_slots_do_not_depend_on_the_width) {
  for (const InstructionSet set : sets_with_normals()) {
    for (const std::int64_t count : {1, 3, 4, 7, 8, 9, 16, 37}) {
      const NoiseBlockKey key{
          .key = 0x0123456789abcdef, .run = 0x1fffffffd, .word1 = 25, .purpose = 2u << 24};
      std::vector<std::uint64_t> expected(2 * static_cast<std::size_t>(count)), got(expected);
      normal_kernel(InstructionSet::scalar).bits(key, 5, expected.data(), count);
      normal_kernel(set).bits(key, 5, got.data(), count);
      EXPECT_EQ(got, expected) << instruction_set_name(set);
      for (unsigned quarter = 0; quarter < 4; ++quarter) {
        // one guard behind the end must survive
        std::vector<double> a(static_cast<std::size_t>(count) + 1, 7.0), b(a);
        normal_kernel(InstructionSet::scalar).slots(key, quarter, 5, a.data(), count);
        normal_kernel(set).slots(key, quarter, 5, b.data(), count);
        EXPECT_EQ(a, b) << instruction_set_name(set);
        EXPECT_EQ(b.back(), 7.0);
      }
    }
  }
}

TEST(NormalKernel, lanes_over_runs_give_the_numbers_of_each_run_and_slot) {
  constexpr std::int64_t groups = 11, slots = 3;
  for (const InstructionSet set : sets_with_normals()) {
    // the runs cross a carry from word 0 to word 3
    const NoiseBlockKey key{
        .key = 0xfedcba9876543210, .run = 0x2fffffff0, .word1 = 0xfffffffa - 5, .purpose = 1u << 24};
    std::vector<double> out(groups * slots * 4 * kNoiseLanes);
    normal_kernel(set).runs(key, groups, slots, out.data());
    std::size_t i = 0;
    for (std::int64_t slot = 0; slot < slots; ++slot) {
      for (std::int64_t g = 0; g < groups; ++g) {
        for (unsigned quarter = 0; quarter < 4; ++quarter) {
          for (std::uint64_t lane = 0; lane < kNoiseLanes; ++lane, ++i) {
            NoiseBlockKey one = key;
            one.run += lane;
            one.word1 += static_cast<std::uint32_t>(g);
            double expected;
            normal_kernel(InstructionSet::scalar)
                .slots(one, quarter, static_cast<std::uint32_t>(slot), &expected, 1);
            ASSERT_EQ(out[i], expected) << instruction_set_name(set) << " slot " << slot << " group " << g;
          }
        }
      }
    }
  }
}

TEST(NormalKernel, pairs_do_not_depend_on_the_width) {
  std::vector<std::uint64_t> bits = edge_bits();
  const std::vector<std::uint64_t> more = random_bits(20000);
  bits.insert(bits.end(), more.begin(), more.end());
  const std::vector<double> expected = pairs(InstructionSet::scalar, bits);
  for (const InstructionSet set : sets_with_normals()) {
    const std::vector<double> got = pairs(set, bits);
    for (std::size_t i = 0; i < got.size(); ++i) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(got[i]), std::bit_cast<std::uint64_t>(expected[i]))
          << instruction_set_name(set) << " at " << i;
    }
  }
}

TEST(NormalKernel, pairs_are_within_4_ulp_of_60_digits) {
  std::vector<std::uint64_t> bits = edge_bits();
  const std::vector<std::uint64_t> more = random_bits(2000);
  bits.insert(bits.end(), more.begin(), more.end());
  const std::vector<double> got = pairs(best_instruction_set(), bits);
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const auto [first, second] = pair_of(got, i);
    const auto [exact_first, exact_second] = exact_pair(bits[i]);
    EXPECT_LE(ulps(first, exact_first), 4.0) << std::hex << bits[i];
    EXPECT_LE(ulps(second, exact_second), 4.0) << std::hex << bits[i];
  }
}

TEST(NormalKernel, pairs_are_finite_and_reach_beyond_8_sigma) {
  double largest = 0.0, smallest = 0.0;
  const std::vector<std::uint64_t> bits = edge_bits();
  for (const double x : pairs(best_instruction_set(), bits)) {
    EXPECT_TRUE(std::isfinite(x));
    largest = std::max(largest, x);
    smallest = std::min(smallest, x);
  }
  // u = 2^−53 and an angle of 0, cosine of either sign
  const std::vector<double> tail = pairs(best_instruction_set(), {0x08, 0x88, 0x48, 0xc8});
  EXPECT_NEAR(pair_of(tail, 0).first, 8.571674348652905, 1e-14);  // sqrt(106 ln 2)
  EXPECT_NEAR(pair_of(tail, 1).first, -8.571674348652905, 1e-14);
  EXPECT_NEAR(pair_of(tail, 2).second, 8.571674348652905, 1e-14);
  EXPECT_NEAR(pair_of(tail, 3).second, -8.571674348652905, 1e-14);
  EXPECT_GT(largest, 8.0);
  EXPECT_LT(smallest, -6.0);
}

// Beyond 6 and 7 sigma there is one normal in 5e8 and in 4e11. A radius that reaches so far has a u that
// begins with 20 or 33 zero bits; given these, the tail has a share that a test can count.
TEST(NormalKernel, tails_beyond_6_sigma_have_the_share_of_the_normal_law) {
  std::mt19937_64 generator(7);
  std::vector<std::uint64_t> bits(1 << 19);
  for (const auto& [sigma, zeros] : {std::pair{6.0, 20}, std::pair{6.5, 20}, std::pair{7.0, 33}}) {
    for (std::uint64_t& b : bits) b = generator() >> zeros;
    ASSERT_LT(std::exp(-0.5 * sigma * sigma), std::ldexp(1.0, -zeros));
    const double one_side = 0.5 * std::erfc(sigma / std::numbers::sqrt2);
    const double expected = std::ldexp(one_side, zeros) * 2.0 * static_cast<double>(bits.size());
    ASSERT_GT(expected, 20.0);
    const double bound = 5.0 * std::sqrt(expected);
    double above = 0.0, below = 0.0;
    for (const double x : pairs(best_instruction_set(), bits)) {
      above += x > sigma ? 1.0 : 0.0;
      below += x < -sigma ? 1.0 : 0.0;
    }
    EXPECT_NEAR(above, expected, bound) << sigma;
    EXPECT_NEAR(below, expected, bound) << sigma;
  }
}

TEST(NormalKernel, refuses_an_instruction_set_that_is_not_there) {
  for (const InstructionSet set : kAllSets) {
    if (is_supported(set)) {
      EXPECT_NO_THROW(normal_kernel(set));
    } else {
      EXPECT_THROW(normal_kernel(set), std::invalid_argument);
    }
  }
  EXPECT_THROW(normal_kernel(static_cast<InstructionSet>(99)), std::invalid_argument);  // on any machine
  EXPECT_TRUE(is_supported(InstructionSet::scalar));
  EXPECT_TRUE(is_supported(best_instruction_set()));
}

}  // namespace
}  // namespace credence::internal
