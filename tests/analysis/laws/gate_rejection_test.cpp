#include "analysis/laws/gate_rejection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace credence::internal {
namespace {

/// A random walk with Q = 0.1, R = 1 and its filter, which does not use innovations beyond the gate. NIS of
/// one dimension: P(χ² > ν²/S) = erfc √(ν²/2S).
ChangesByNis walk(double gate, double Q_scale, unsigned seed, int runs = 40, int steps = 100) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  ChangesByNis changes;
  for (int run = 0; run < runs; ++run) {
    double P = 1.0, error = normal(bits);
    for (int k = 0; k < steps; ++k) {
      const double before = P;
      error -= std::sqrt(0.1) * normal(bits);
      P += 0.1 * Q_scale;
      const double nu = normal(bits) - error, S = P + 1.0;
      if (nu * nu <= gate * S) {
        error += P / S * nu;
        P /= S;
      }
      if (k >= steps / 5) changes.add(std::erfc(std::sqrt(0.5 * nu * nu / S)), std::log(P / before));
    }
  }
  return changes;
}

constexpr double kNone = 1e300, k95 = 3.8415;  // χ²(1)

TEST(GateRejection, IsFoundWhereItIs) {
  const auto found = find_gate_rejection(walk(k95, 1.0, 1));
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(found->p_value, 1e-9);
  EXPECT_NEAR(std::log2(found->expected), std::log2(0.05), 0.25);  // a bin
  EXPECT_GT(found->share, 0.05);  // as errors grow beyond P where right innovations are not used
  EXPECT_LT(found->share, 0.15);
}

TEST(GateRejection, IsFoundWhereQIsWrongAsWell) {
  for (const double Q_scale : {0.2, 5.0}) {
    const auto found = find_gate_rejection(walk(k95, Q_scale, 4));
    ASSERT_TRUE(found.has_value()) << Q_scale;
    EXPECT_LT(found->p_value, 1e-9) << Q_scale;
  }
}

// As P of several models does, or noise that adapts itself: no step anywhere.
TEST(GateRejection, OfAPThatGrowsWithNisNoneIsFound) {
  std::mt19937_64 bits(5);
  std::normal_distribution<double> normal;
  for (const double spread : {0.1, 0.5}) {
    ChangesByNis changes;
    for (int i = 0; i < 4000; ++i) {
      const double nu = normal(bits);
      changes.add(std::erfc(std::sqrt(0.5) * std::abs(nu)), 0.2 * nu * nu + spread * normal(bits));
    }
    EXPECT_FALSE(find_gate_rejection(changes).has_value()) << spread;
  }
}

// P of a filter that uses all it logs is the same in all runs, be its Q right or not: of no size is what
// tells its changes apart.
TEST(GateRejection, OfAFilterWithoutAGateNoneIsFound) {
  for (const double Q_scale : {0.2, 1.0, 5.0})
    EXPECT_FALSE(find_gate_rejection(walk(kNone, Q_scale, 2)).has_value()) << Q_scale;
}

// Changes that are independent of NIS, with outliers: in 2,000 studies p ≤ 1 % in 1 % of them at most, but
// for five standard errors.
TEST(GateRejection, IsRareByChance) {
  std::mt19937_64 bits(3);
  std::uniform_real_distribution<double> uniform;
  std::student_t_distribution<double> heavy(3.0);
  int found = 0;
  for (int study = 0; study < 2000; ++study) {
    ChangesByNis changes;
    for (int i = 0; i < 200; ++i) changes.add(uniform(bits), heavy(bits));
    const auto gate = find_gate_rejection(changes);
    found += gate && gate->p_value <= 0.01;
  }
  EXPECT_LE(found, 20 + 5 * std::sqrt(20.0));
}

TEST(GateRejection, NeedsEightOnEitherSide) {
  ChangesByNis changes;
  EXPECT_FALSE(find_gate_rejection(changes).has_value());
  for (int i = 0; i < 100; ++i) changes.add(0.5, -1.0 + 0.001 * (i % 7));
  for (int i = 0; i < 7; ++i) changes.add(0.01, 1.0 + 0.001 * i);
  EXPECT_FALSE(find_gate_rejection(changes).has_value());
  changes.add(0.0, 1.0);
  EXPECT_TRUE(find_gate_rejection(changes).has_value());
  changes.add(0.01, std::nan(""));  // of a step whose P is not known
  EXPECT_EQ(changes.bins.size(), static_cast<std::size_t>(ChangesByNis::kBins));
}

TEST(GateRejection, ChunksAddUp) {
  ChangesByNis first = walk(k95, 1.0, 4, 20);
  const ChangesByNis second = walk(k95, 1.0, 5, 20);
  ChangesByNis all;
  all.merge(first);
  all.merge(second);
  std::int64_t count = 0;
  for (const Moments& bin : all.bins) count += bin.count;
  EXPECT_EQ(count, 2 * 20 * 80);
  all.merge({});
  EXPECT_TRUE(find_gate_rejection(all).has_value());
}

}  // namespace
}  // namespace credence::internal
