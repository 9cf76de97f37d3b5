#include "analysis/laws/chi_square/chi_square_dependent_sum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(ChiSquareDependentSum, BoundsAndPValueAgree) {
  const std::vector<double> dofs{2.0, 2.0, 5.0, 400.0};
  for (const double confidence : {0.5, 0.95, 0.999}) {
    const ChiSquareBounds bounds = dependent_sum_bounds(dofs, confidence);
    EXPECT_NEAR(dependent_sum_p_value(bounds.lower, dofs), 1.0 - confidence, 1e-9);
    EXPECT_NEAR(dependent_sum_p_value(bounds.upper, dofs), 1.0 - confidence, 1e-9);
  }
  EXPECT_EQ(dependent_sum_p_value(409.0, dofs), 1.0);
}

TEST(ChiSquareDependentSum, HoldsItsLevelForEqualAndForIndependentTerms) {
  // Terms that are all equal, that are independent, and that are partly antithetic: never above the level.
  constexpr int kStudies = 20000;
  constexpr int kTerms = 8;
  const std::vector<double> dofs(kTerms, 3.0);
  std::mt19937_64 generator(11);
  std::chi_squared_distribution<double> chi(3.0);
  for (const double alpha : {0.05, 0.01}) {
    const ChiSquareBounds bounds = dependent_sum_bounds(dofs, 1.0 - alpha);
    int equal = 0;
    int independent = 0;
    int antithetic = 0;
    for (int study = 0; study < kStudies; ++study) {
      const double first = chi(generator);
      double sum = 0.0;
      for (int i = 0; i < kTerms; ++i) sum += chi(generator);
      const double other = chi_square_quantile(chi_square_survival(first, 3.0), 3.0);
      const double mixed = 0.5 * kTerms * (first + other);
      equal += kTerms * first < bounds.lower || kTerms * first > bounds.upper;
      independent += sum < bounds.lower || sum > bounds.upper;
      antithetic += mixed < bounds.lower || mixed > bounds.upper;
    }
    const double limit = kStudies * (alpha + 5.0 * test::binomial_standard_error(alpha, kStudies));
    EXPECT_LE(equal, limit);
    EXPECT_LE(independent, limit);
    EXPECT_LE(antithetic, limit);
    EXPECT_GT(equal, 0.1 * alpha * kStudies) << "so conservative that it is useless";
  }
}

TEST(ChiSquareDependentSum, WorstDependenceAttainsTheLevel) {
  // The worst case: equal in the body, and in the upper tail of probability p the sum is constant at its
  // mean there. Then P(sum ≥ bound) = p: no smaller bound is valid.
  const std::vector<double> dofs(4, 2.0);
  const double p = 0.025;
  const double constant_sum = 4.0 * chi_square_upper_tail_mean(p, 2.0);
  EXPECT_NEAR(dependent_sum_bounds(dofs, 0.95).upper, constant_sum, 1e-9);
}

TEST(ChiSquareDependentSum, OneSidedPValuesInvertTheBounds) {
  const std::vector<double> dofs{2.0, 3.0, 3.0};
  const ChiSquareBounds bounds = dependent_sum_bounds(dofs, 0.9);
  EXPECT_NEAR(dependent_sum_tails(bounds.upper, dofs).upper, 0.05, 1e-9);
  EXPECT_EQ(dependent_sum_tails(bounds.upper, dofs).lower, 1.0);
  EXPECT_NEAR(dependent_sum_tails(bounds.lower, dofs).lower, 0.05, 1e-9);
  EXPECT_EQ(dependent_sum_tails(8.0, dofs).lower, 1.0);
  // Not capped at one half: just below the mean nothing speaks against it.
  EXPECT_GT(dependent_sum_tails(7.99, dofs).lower, 0.9);
}

TEST(ChiSquareDependentSum, ExtremesAreData) {
  const std::vector<double> dofs(3, 1.0);
  EXPECT_EQ(dependent_sum_p_value(std::numeric_limits<double>::infinity(), dofs), 0.0);
  EXPECT_EQ(dependent_sum_p_value(1e9, dofs), 0.0);
  EXPECT_EQ(dependent_sum_p_value(-1.0, dofs), 0.0);
  EXPECT_LT(dependent_sum_p_value(0.0, dofs), 1e-100);
  EXPECT_TRUE(std::isnan(dependent_sum_p_value(std::nan(""), dofs)));
  EXPECT_LT(dependent_sum_p_value(1.01e9, std::vector<double>(1, 1e9)), 1e-100);
  EXPECT_THROW(dependent_sum_p_value(1.0, {}), std::invalid_argument);
  EXPECT_THROW(dependent_sum_p_value(1.0, std::vector<double>{1.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(dependent_sum_bounds(dofs, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
