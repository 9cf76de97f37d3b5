#include "analysis/laws/gate_rejection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

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

/// The walk by a sensor that is there in four of five steps, and another one at every second, whose R the
/// filter takes for `R_scale` of what it is: the changes at the steps of the first one, as they are and as
/// they may be compared.
std::pair<ChangesByNis, ChangesByNis> walk_of_two(double gate, double R_scale, unsigned seed, int runs) {
  constexpr double kQ = 0.03, kNear = 3.0, kFar = 3.0;
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  std::bernoulli_distribution there(0.8);
  ChangesByNis raw, comparable;
  for (int run = 0; run < runs; ++run) {
    double P = 1.0, error = normal(bits);
    ChangesOfRun of_run;
    std::vector<double> survival, changes;
    const auto update = [&](double R, double claimed) {
      const double nu = std::sqrt(R) * normal(bits) - error, S = P + claimed;
      if (nu * nu <= gate * S) {
        error += P / S * nu;
        P *= claimed / S;
      }
      return std::erfc(std::sqrt(0.5 * nu * nu / S));
    };
    for (int k = 0; k < 100; ++k) {
      const double before = P;
      error -= std::sqrt(kQ) * normal(bits);
      P += kQ;
      const bool near = there(bits), far = k % 2 == 0 && there(bits);
      const double of_near = near ? update(kNear, kNear) : 0.0;
      if (far) update(kFar, R_scale * kFar);
      if (!near || k < 20) continue;
      of_run.add(far ? 1 : 0, std::log(before), std::log(P / before));
      survival.push_back(of_near);
      changes.push_back(std::log(P / before));
    }
    const auto [all, taken] = of_run.comparable();
    for (std::size_t i = 0; i < all.size(); ++i) {
      raw.add(survival[i], changes[i]);
      comparable.add(survival[i], all[i], taken);
    }
  }
  return {raw, comparable};
}

// A wrong R of a sensor that comes and goes makes P smaller than it should be where NIS of the other is
// large: of 60 seeds these two have a gate by the changes as they are.
TEST(GateRejection, SensorsThatComeAndGoMakeNone) {
  for (const unsigned seed : {6U, 45U}) {
    const auto [raw, comparable] = walk_of_two(kNone, 0.05, seed, 200);
    const auto found = find_gate_rejection(raw);
    ASSERT_TRUE(found.has_value()) << seed;
    EXPECT_LT(found->p_value, 1e-3) << seed;
    EXPECT_FALSE(find_gate_rejection(comparable).has_value()) << seed;
  }
}

TEST(GateRejection, IsFoundWhereSensorsComeAndGo) {
  for (const double R_scale : {1.0, 0.25}) {
    const auto found = find_gate_rejection(walk_of_two(k95, R_scale, 9, 60).second);
    ASSERT_TRUE(found.has_value()) << R_scale;
    EXPECT_LT(found->p_value, 1e-9) << R_scale;
    EXPECT_NEAR(std::log2(found->expected), std::log2(0.05), 0.25) << R_scale;
  }
}

TEST(GateRejection, ChangesAreComparedWhereTheSameIsSeen) {
  ChangesOfRun alone;
  for (const double change : {1.0, 3.0, 2.0}) alone.add(4, 10.0 * change, change);
  EXPECT_EQ(alone.comparable().changes, (std::vector<double>{1.0, 3.0, 2.0}));
  EXPECT_EQ(alone.comparable().variance, 0.0);
  ChangesOfRun mixed;  // −0.5 before, and 1 or 7; the third is seen too seldom
  for (const double before : {1.0, 2.0, 3.0, 4.0}) mixed.add(1, before, 1.0 - 0.5 * before);
  for (const double before : {1.0, 2.0, 3.0, 4.0}) mixed.add(2, before, 7.0 - 0.5 * before);
  for (const double before : {1.0, 2.0, 3.0}) mixed.add(3, before, before);
  const auto [left, taken] = mixed.comparable();
  ASSERT_EQ(left.size(), 11U);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(left[i], 0.0, 1e-12) << i;
  for (std::size_t i = 8; i < 11; ++i) EXPECT_TRUE(std::isnan(left[i])) << i;
  EXPECT_NEAR(taken, (2.0 * 4.0 * 9.0 + 2.0 * 0.25 * 5.0) / 7.0, 1e-12);  // of ±3 and of −0.5 before
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
