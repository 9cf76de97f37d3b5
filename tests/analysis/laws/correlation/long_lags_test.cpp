#include "analysis/laws/correlation/long_lags.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

Vector value(double x) { return Vector::Constant(1, x); }

LagSeries constant_run(int steps, double x) {
  LagSeries run(1);
  for (int k = 0; k < steps; ++k) run.add(value(x));
  return run;
}

// 600 values k of two runs: blocks of 16 have the means 8.5, 24.5, …, those of 256 the means 128.5 and 384.5.
TEST(LongLags, AreOfTheMeansOfBlocks) {
  LongLags lags(1);
  LagSeries run(1);
  for (int k = 1; k <= 600; ++k) run.add(value(k));
  for (int i = 0; i < 2; ++i) lags.add_run(run);
  const auto& [values, short_blocks, long_blocks] = lags.levels();
  EXPECT_EQ(values.pairs(0), 1200);
  EXPECT_EQ(short_blocks.pairs(0), 2 * 37) << "what is left over is left out";
  EXPECT_EQ(short_blocks.pairs(20), 2 * 17);
  double product = 0.0;
  for (int i = 2; i < 37; ++i) product += (16.0 * i + 8.5) * (16.0 * (i - 2) + 8.5);
  EXPECT_DOUBLE_EQ(short_blocks.product(2)(0, 0), 2.0 * product);
  EXPECT_EQ(long_blocks.pairs(1), 2) << "none of two runs together";
  EXPECT_DOUBLE_EQ(long_blocks.product(1)(0, 0), 2.0 * 128.5 * 384.5);
}

TEST(LongLags, AMeanIsOfTheValuesThatAreThere) {
  LongLags lags(1);
  LagSeries run(1);
  for (int k = 0; k < 64; ++k) {
    if (k % 4 == 0 && k / 16 != 2) {
      run.add(value(k / 16 + 1.0));
    } else {
      run.add_missing();
    }
  }
  lags.add_run(run);
  const LagProducts& blocks = lags.levels()[1];
  EXPECT_EQ(blocks.pairs(0), 3);
  EXPECT_EQ(blocks.product(0)(0, 0), 1.0 + 4.0 + 16.0);
  EXPECT_EQ(blocks.product(1)(0, 0), 1.0 * 2.0) << "the third has none";
  EXPECT_EQ(blocks.product(2)(0, 0), 2.0 * 4.0);
}

TEST(LongLags, AddUpAndMoveToAnotherMean) {
  LongLags one(1), other(1);
  one.add_run(constant_run(32, 3.0));
  other.add_run(constant_run(48, 5.0));
  one.merge(other);
  EXPECT_EQ(one.levels()[1].product(1)(0, 0), 9.0 + 2.0 * 25.0);
  EXPECT_EQ(one.about(value(4.0)).levels()[1].product(1)(0, 0), 59.0 - 3.0 * 16.0);
}

}  // namespace
}  // namespace credence::internal
