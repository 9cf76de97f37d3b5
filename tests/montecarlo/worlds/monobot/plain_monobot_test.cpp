#include "montecarlo/worlds/monobot/plain_monobot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace credence::internal {
namespace {

// The filter is consistent, so that the exact means are the dimensions (theory, sections 3 and 6), and the
// variances those of chi-square, twice as large.
TEST(PlainMonobot, MeansAndVariancesAreThoseOfAConsistentFilter) {
  for (const Index N : {1, 2, 5}) {
    SCOPED_TRACE(N);
    const std::int64_t kRuns = 4000;
    std::mt19937_64 generator(1);
    std::vector<Moments> nees(20), nis(20);
    run_plain_monobot(N, kRuns, generator, nees, nis);
    for (const std::size_t k : {std::size_t{0}, std::size_t{7}, std::size_t{19}}) {
      const auto expect_chi_square = [kRuns](const Moments& m, double dof) {
        EXPECT_EQ(m.count, kRuns);
        EXPECT_NEAR(m.mean, dof, 5.0 * std::sqrt(2.0 * dof / static_cast<double>(kRuns)));
        // Var of a sample variance: (μ₄ − σ⁴)/M with μ₄ = 12 n (n + 4), σ² = 2 n.
        const double error =
            std::sqrt((12.0 * dof * (dof + 4.0) - 4.0 * dof * dof) / static_cast<double>(kRuns));
        EXPECT_NEAR(m.variance(), 2.0 * dof, 5.0 * error);
      };
      expect_chi_square(nees[k], static_cast<double>(N + 1));
      expect_chi_square(nis[k], static_cast<double>(N));
    }
  }
}

TEST(PlainMonobot, GoesOnWhereTheGeneratorIs) {
  std::mt19937_64 generator(1);
  std::vector<Moments> nees(3), nis(3);
  run_plain_monobot(1, 2, generator, nees, nis);
  const Moments two = nees[2];
  run_plain_monobot(1, 2, generator, nees, nis);
  EXPECT_EQ(nees[2].count, 4);
  EXPECT_NE(nees[2].mean, two.mean);
}

TEST(PlainMonobot, RefusesWhatItWasNotWrittenFor) {
  std::mt19937_64 generator(1);
  std::vector<Moments> nees(3), nis(3), short_one(2);
  EXPECT_THROW(run_plain_monobot(3, 1, generator, nees, nis), std::invalid_argument);
  EXPECT_THROW(run_plain_monobot(1, 1, generator, nees, short_one), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
