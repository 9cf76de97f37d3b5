#include "core/linear_algebra/symmetry.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/nan.h"

namespace credence::internal {
namespace {

Matrix nearly_symmetric(double variance, double upper, double lower) {
  Matrix P(2, 2);
  P << variance, upper, lower, 4.0 * variance;
  return P;
}

TEST(Symmetry, triangles_may_differ_in_units_of_the_standard_deviations) {
  // Standard deviations 3 and 6: a tolerance of 1e-3 is 0.018.
  EXPECT_TRUE(is_symmetric(nearly_symmetric(9.0, 1.0, 1.0179), 1e-3));
  EXPECT_FALSE(is_symmetric(nearly_symmetric(9.0, 1.0, 1.0181), 1e-3));
  EXPECT_FALSE(is_symmetric(nearly_symmetric(9.0, 1.0181, 1.0), 1e-3));
  for (const double unit : {1e-40, 1e40}) {
    EXPECT_TRUE(is_symmetric(unit * nearly_symmetric(9.0, 1.0, 1.0179), 1e-3)) << unit;
    EXPECT_FALSE(is_symmetric(unit * nearly_symmetric(9.0, 1.0, 1.0181), 1e-3)) << unit;
  }
  EXPECT_TRUE(is_symmetric(nearly_symmetric(9.0, 1.0, 1.0), 0.0));
}

TEST(Symmetry, every_pair_is_looked_at) {
  for (Index i = 0; i < 4; ++i) {
    for (Index j = 0; j < 4; ++j) {
      Matrix P = Matrix::Identity(4, 4);
      P(i, j) += 0.5;
      EXPECT_EQ(is_symmetric(P, 0.1), i == j);
    }
  }
}

TEST(Symmetry, entries_that_are_not_finite_do_not_agree) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {kNaN, infinity, -infinity}) {
    EXPECT_FALSE(is_symmetric(nearly_symmetric(9.0, bad, 1.0), 1.0));
    EXPECT_FALSE(is_symmetric(nearly_symmetric(9.0, 1.0, bad), 1.0));
    EXPECT_FALSE(is_symmetric(nearly_symmetric(9.0, bad, bad), 1.0));
  }
  EXPECT_FALSE(is_symmetric(nearly_symmetric(kNaN, 1.0, 1.0), 1.0));
}

TEST(Symmetry, both_triangles_become_the_lower_one_whatever_they_were) {
  Matrix P = nearly_symmetric(9.0, 1.0, 1.0001), Q = nearly_symmetric(9.0, 1.0, 2.0);
  EXPECT_TRUE(make_symmetric(P));
  EXPECT_EQ(P, nearly_symmetric(9.0, 1.0001, 1.0001));
  EXPECT_FALSE(make_symmetric(Q));
  EXPECT_EQ(Q, nearly_symmetric(9.0, 2.0, 2.0));
}

TEST(Symmetry, nothing_and_a_variance_are_symmetric) {
  Matrix empty(0, 0), one = Matrix::Constant(1, 1, 2.0);
  EXPECT_TRUE(make_symmetric(empty));
  EXPECT_TRUE(make_symmetric(one));
  EXPECT_EQ(one(0, 0), 2.0);
}

}  // namespace
}  // namespace credence::internal
