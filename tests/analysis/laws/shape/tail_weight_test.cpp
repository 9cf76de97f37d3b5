#include "analysis/laws/shape/tail_weight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(RunTails, ByHand) {
  RunTails run;
  EXPECT_TRUE(std::isnan(run.value()));
  run.add(3.0, 1.0);
  run.add(1.0, 2.0);
  // K = 10/(3 + 8), X = 4/3.
  EXPECT_NEAR(run.value(), 10.0 / 11.0 - 8.0 / 3.0 + 2.0, 1e-15);
}

// Fifty runs of 40 steps of two components, each drawn by `component`, times √factor.
template <typename Component>
int rejections(int studies, double factor, Component component) {
  int rejected = 0;
  for (int study = 0; study < studies; ++study) {
    SkewedMoments values;
    for (int run = 0; run < 50; ++run) {
      RunTails tails;
      for (int step = 0; step < 40; ++step) {
        tails.add(factor * (std::pow(component(), 2) + std::pow(component(), 2)), 2.0);
      }
      values.add(tails.value());
    }
    rejected += heavy_tail_p_value(values) <= 0.025;
  }
  return rejected;
}

TEST(TailWeight, GaussianErrorsOfAnyNearScaleAreNotHeavy) {
  constexpr int kStudies = 1500;
  std::mt19937_64 generator(81);
  std::normal_distribution<double> normal;
  const double most = 0.025 + 5.0 * test::binomial_standard_error(0.025, kStudies);
  EXPECT_LE(rejections(kStudies, 1.0, [&] { return normal(generator); }) / 1500.0, most);
  EXPECT_GE(rejections(kStudies, 1.0, [&] { return normal(generator); }), 5);
  EXPECT_LE(rejections(kStudies, 1.03, [&] { return normal(generator); }) / 1500.0, most);
}

TEST(TailWeight, SeesStudentsNoiseOfTheRightVariance) {
  std::mt19937_64 generator(82);
  std::student_t_distribution<double> student(5.0);
  EXPECT_GE(rejections(100, 1.0, [&] { return student(generator) * std::sqrt(0.6); }), 95);
}

TEST(TailWeight, FarValuesAreCountedAndAScaleIsNotTakenForThem) {
  // 20 of 10,000 beyond the 99.99 % quantile: binomial, 1 expected.
  EXPECT_LT(far_tail_p_value({.inside = 9980, .total = 10000}, 0.9999), 1e-15);
  EXPECT_EQ(far_tail_p_value({.inside = 9990, .total = 10000}, 0.9999), 1.0);
  // A factor 1.2 on two dof: P(χ² > 18.42/1.2) = 4.6e-4.
  EXPECT_EQ(far_tail_p_value({.inside = 999540, .total = 1000000}, 0.9999), 1.0);
  EXPECT_EQ(far_tail_p_value({.inside = 10000, .total = 10000}, 0.9999), 1.0);
  EXPECT_EQ(far_tail_p_value({}, 0.9999), 1.0);
}

TEST(TailWeight, TooLittleData) {
  EXPECT_TRUE(std::isnan(heavy_tail_p_value({})));
  EXPECT_TRUE(std::isnan(heavy_tail_p_value({.count = 9, .mean = 1.0, .m2 = 1.0})));
  EXPECT_TRUE(std::isnan(heavy_tail_p_value({.count = 20, .mean = 1.0})));
}

}  // namespace
}  // namespace credence::internal
