#include "analysis/laws/mean/mean_at_steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace credence::internal {
namespace {

// Four runs of one component around a mean, whose squared deviations add up to `scatter`.
VectorMoments four_runs(double mean, double scatter) {
  VectorMoments runs;
  runs.count = 4;
  runs.mean = Vector::Constant(1, mean);
  runs.scatter = Matrix::Constant(1, 1, scatter);
  return runs;
}

// By hand: of M = 4, mean 2 and scatter 6, |ū|² − tr C/M = 4 − 2/4 = 3.5 and E|u|² − n = 4 + 6/4 − 1 = 4.5;
// of mean 0 and scatter 6, −0.5 and 0.5. T² = 4·3·4/6 = 8, F(1, 3): p = 0.0663 (scipy.stats.f.sf(8, 1, 3)).
TEST(MeanAtSteps, IsAShareOfTheExcess) {
  const MeanAtSteps one = test_mean_at_steps({{1, four_runs(2.0, 6.0)}});
  EXPECT_NEAR(one.explained, 3.5 / 4.5, 1e-12);
  EXPECT_NEAR(one.p_value, 0.0663, 5e-5);
  const MeanAtSteps both = test_mean_at_steps({{1, four_runs(2.0, 6.0)}, {2, four_runs(0.0, 6.0)}});
  EXPECT_NEAR(both.explained, 3.0 / 5.0, 1e-12);
  EXPECT_NEAR(both.p_value, 2.0 * one.p_value, 1e-12);
}

// Of steps 1 and 10 the first is that of the first fifth: |μ|² of mean 8 and scatter 6 is 64 − 0.5, of mean 0
// −0.5, which is none. T² = 4·3·64/6 = 128, F(1, 3): p = 0.0015 (scipy.stats.f.sf(128, 1, 3)), of two steps.
TEST(MeanAtSteps, PassesWhereNoneIsLeftAfterTheFirstFifth) {
  const MeanAtSteps early = test_mean_at_steps({{1, four_runs(8.0, 6.0)}, {10, four_runs(0.0, 6.0)}});
  EXPECT_NEAR(early.early_square, 63.5, 1e-12);
  EXPECT_EQ(early.later_square, 0.0);
  EXPECT_EQ(early.later_p_value, 1.0);
  EXPECT_TRUE(early.passes(0.01));
  EXPECT_FALSE(early.passes(0.002)) << "it is none";
  const MeanAtSteps both = test_mean_at_steps({{1, four_runs(8.0, 6.0)}, {10, four_runs(8.0, 6.0)}});
  EXPECT_FALSE(both.passes(0.01));
}

// Errors of either sign that are too large have no mean; nor have those that are too small an excess.
TEST(MeanAtSteps, OfAWrongCovarianceIsNone) {
  EXPECT_EQ(test_mean_at_steps({{1, four_runs(0.1, 60.0)}}).explained, 0.0);
  EXPECT_EQ(test_mean_at_steps({{1, four_runs(0.5, 0.6)}}).explained, 0.0);
}

/// 20 runs of 2 components at steps 1, 2, 4, …, 512: √ρ of their noise is the same, and a bias is added.
MeanAtSteps of_runs(double shared, double bias, double size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vector::NullaryExpr(2, [&] { return normal(random); }).eval(); };
  std::map<std::int64_t, VectorMoments> whitened;
  for (std::int64_t step = 1; step <= 512; step *= 2) {
    const Vector same = draw();
    for (int run = 0; run < 20; ++run)
      whitened[step].add(
          size * (std::sqrt(shared) * same + std::sqrt(1.0 - shared) * draw() + Vector::Constant(2, bias)));
  }
  return test_mean_at_steps(whitened);
}

TEST(MeanAtSteps, TellsNoiseThatRunsShareFromABias) {
  int shared = 0;
  double square = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    shared += of_runs(0.5, 0.0, 1.0, seed).shared(0.003) ? 1 : 0;
    square += of_runs(0.5, 0.0, 1.0, seed).square / 40.0;
    EXPECT_FALSE(of_runs(0.0, 0.0, 1.0, seed).shared(0.003)) << seed;  // right
    EXPECT_FALSE(of_runs(0.0, 1.0, 1.0, seed).shared(0.003)) << seed;  // a bias
    EXPECT_FALSE(of_runs(0.0, 1.0, 0.7, seed).shared(0.003)) << seed;  // of a P that is too large
    EXPECT_FALSE(of_runs(0.0, 0.0, 0.5, seed).shared(0.003)) << seed;  // no mean
  }
  EXPECT_GE(shared, 38);
  const MeanAtSteps half = of_runs(0.5, 0.0, 1.0, 1);
  EXPECT_NEAR(half.spread, 0.5, 0.19);  // 5 standard errors of 380 squares
  EXPECT_NEAR(square, 0.5, 0.13);       // of 800
}

TEST(MeanAtSteps, NeedsMoreRunsThanComponents) {
  VectorMoments two;
  two.add(Vector::Constant(2, 9.0));
  two.add(Vector::Constant(2, 8.0));
  for (const MeanAtSteps& none : {test_mean_at_steps({}), test_mean_at_steps({{1, two}})}) {
    EXPECT_EQ(none.explained, 0.0);
    EXPECT_EQ(none.p_value, 1.0);
  }
}

}  // namespace
}  // namespace credence::internal
