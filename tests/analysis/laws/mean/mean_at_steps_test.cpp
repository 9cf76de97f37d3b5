#include "analysis/laws/mean/mean_at_steps.h"

#include <gtest/gtest.h>

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

// Errors of either sign that are too large have no mean; nor have those that are too small an excess.
TEST(MeanAtSteps, OfAWrongCovarianceIsNone) {
  EXPECT_EQ(test_mean_at_steps({{1, four_runs(0.1, 60.0)}}).explained, 0.0);
  EXPECT_EQ(test_mean_at_steps({{1, four_runs(0.5, 0.6)}}).explained, 0.0);
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
