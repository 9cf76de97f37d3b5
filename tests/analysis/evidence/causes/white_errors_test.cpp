#include "analysis/evidence/causes/white_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace credence::internal {
namespace {

/// NEES of ten runs of 300 rows of an error of variance 1 that keeps `memory` of itself from row to row, and
/// of white noise beside it.
std::vector<std::vector<double>> nees_of(double memory, double noise, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> runs(10, std::vector<double>(300));
  for (std::vector<double>& run : runs) {
    double error = normal(random);
    for (double& value : run) {
      error = memory * error + std::sqrt(1.0 - memory * memory) * normal(random);
      const double seen = error + noise * normal(random);
      value = seen * seen;
    }
  }
  return runs;
}

// Of an error of variance 1 and noise of variance s, Var(NEES) = 2 (1 + s)² and C_h = 2 a^2h: of s = 1 the
// share is 1 − 1/4, whatever the memory a. The standard deviation over seeds is 0.05 at most.
TEST(WhiteErrors, AreAShareOfTheVarianceOfNees) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_NEAR(white_share_of(nees_of(0.95, 1.0, seed)), 0.75, 0.25) << seed;
    EXPECT_LT(white_share_of(nees_of(0.95, 0.0, seed)), 0.25) << seed;
    EXPECT_LT(white_share_of(nees_of(0.99, 0.0, seed)), 0.25) << seed;
  }
}

// A row of a few runs that is far off, or one in 15 of all, as where a fine sensor measures, is no noise of
// every row. Three of 40 among 3,000 of variance 2 would have a share of 1.6 in 3.6.
TEST(WhiteErrors, FewRowsAreNone) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<std::vector<double>> right = nees_of(0.95, 0.0, seed);
    std::vector<std::vector<double>> far_off = right, fine = right;
    for (std::size_t run = 0; run < 3; ++run) far_off[run][100] = 40.0;
    EXPECT_LT(white_share_of(far_off), 0.25) << seed;
    for (std::vector<double>& run : fine)
      for (std::size_t row = 14; row < run.size(); row += 15) run[row] *= 10.0;
    EXPECT_LT(white_share_of(fine), 0.25) << seed;
  }
}

// A filter of a large gain forgets its errors as fast as noise does.
TEST(WhiteErrors, AreNotToldWhereErrorsFadeFast) {
  EXPECT_EQ(white_share_of(nees_of(0.5, 0.0, 1)), 0.0);
  EXPECT_EQ(white_share_of(nees_of(0.0, 1.0, 1)), 0.0);
  std::vector<std::vector<double>> few = nees_of(0.95, 1.0, 1);
  few.resize(1);
  EXPECT_EQ(white_share_of(few), 0.0);
  EXPECT_EQ(white_share_of({}), 0.0);
}

}  // namespace
}  // namespace credence::internal
