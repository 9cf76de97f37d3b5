#include "analysis/laws/chi_square/chi_square_cumulants.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(ChiSquareCumulants, ExactForAMultipleOfChiSquare) {
  const double scale = 2.5;
  const Cumulants cumulants{scale * 7.0, scale * scale * 14.0, scale * scale * scale * 56.0};
  const ChiSquareBounds bounds = sum_bounds(cumulants, 0.99);
  EXPECT_NEAR(bounds.lower, scale * chi_square_quantile(0.005, 7.0), 1e-9);
  EXPECT_NEAR(bounds.upper, scale * chi_square_quantile(0.995, 7.0), 1e-9);
  EXPECT_NEAR(two_sided_p_value(bounds.upper, cumulants), 0.01, 1e-9);
  EXPECT_NEAR(upper_p_value(bounds.upper, cumulants), 0.005, 1e-9);
  EXPECT_NEAR(upper_p_value(bounds.lower, cumulants), 0.995, 1e-9);
}

TEST(ChiSquareCumulants, MirrorsForNegativeSkewness) {
  const Cumulants right{0.0, 14.0, 56.0};
  const Cumulants left{0.0, 14.0, -56.0};
  EXPECT_NEAR(sum_bounds(left, 0.9).lower, -sum_bounds(right, 0.9).upper, 1e-12);
  EXPECT_NEAR(two_sided_p_value(-9.0, left), two_sided_p_value(9.0, right), 1e-12);
  EXPECT_NEAR(upper_p_value(3.0, left), 1.0 - upper_p_value(-3.0, right), 1e-12);
}

TEST(ChiSquareCumulants, NoSkewnessIsNormal) {
  const ChiSquareBounds bounds = sum_bounds({10.0, 4.0, 0.0}, 0.95);
  EXPECT_NEAR(bounds.lower, 10.0 - 2.0 * 1.959963985, 1e-5);
  EXPECT_NEAR(bounds.upper, 10.0 + 2.0 * 1.959963985, 1e-5);
}

TEST(ChiSquareCumulants, WeightedSumHasTheRightTails) {
  // Ten runs of Σ w_i χ²(1) with weights 4, 2, 1, 1, 1, ½ × 8: one run is far from a single χ².
  constexpr int kRuns = 10;
  const double weights[] = {4, 2, 1, 1, 1, .5, .5, .5, .5, .5, .5, .5, .5};
  Cumulants cumulants;
  for (const double w : weights) cumulants = cumulants + Cumulants{w, 2 * w * w, 8 * w * w * w} * kRuns;
  constexpr int kStudies = 20000;
  std::mt19937_64 generator(4);
  std::normal_distribution<double> normal;
  int rejected = 0;
  const ChiSquareBounds bounds = sum_bounds(cumulants, 0.95);
  for (int study = 0; study < kStudies; ++study) {
    double sum = 0.0;
    for (const double w : weights) {
      for (int run = 0; run < kRuns; ++run) sum += w * std::pow(normal(generator), 2);
    }
    rejected += sum < bounds.lower || sum > bounds.upper;
  }
  EXPECT_NEAR(static_cast<double>(rejected) / kStudies, 0.05,
              5.0 * test::binomial_standard_error(0.05, kStudies));
}

TEST(ChiSquareCumulants, RejectsImpossibleArguments) {
  EXPECT_THROW(two_sided_p_value(1.0, Cumulants{1.0, 0.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(two_sided_p_value(1.0, Cumulants{1.0, std::nan(""), 0.0}), std::invalid_argument);
  EXPECT_THROW(sum_bounds({1.0, 1.0, 0.0}, 1.0), std::invalid_argument);
  EXPECT_TRUE(std::isnan(two_sided_p_value(std::nan(""), Cumulants{1.0, 1.0, 1.0})));
}

}  // namespace
}  // namespace credence::internal
