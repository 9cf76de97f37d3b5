#include "analysis/laws/shape/tail_weight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>
#include <vector>

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
    TailSums values;
    for (int run = 0; run < 50; ++run) {
      RunTails tails;
      for (int step = 0; step < 40; ++step) {
        tails.add(factor * (std::pow(component(), 2) + std::pow(component(), 2)), 2.0);
      }
      values.add(tails);
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

// Half of fifty runs are heavier, and their weights are 1 on average; or all are.
TEST(TailWeight, CountsTheRunsThatAreHeavier) {
  const SkewedMoments weights{.count = 50, .mean = 1.0, .m2 = 1.0};
  const TailSums half{.weights = weights, .heavier = {.inside = 25, .total = 50}};
  EXPECT_EQ(heavy_tail_p_value(half), 1.0);
  const TailSums all{.weights = weights, .heavier = {.inside = 50, .total = 50}};
  EXPECT_NEAR(heavy_tail_p_value(all), 2.0 * std::pow(0.5, 50), 1e-28);
  RunTails run;
  run.add(2.0, 2.0);
  EXPECT_FALSE(run.heavier());  // K = 4/8, X = 1
  run.add(12.0, 2.0);
  EXPECT_FALSE(run.heavier());  // K = 148/16, X² = 3.5²
  run.add(0.0, 2.0);
  EXPECT_TRUE(run.heavier());  // K = 148/24, X² = (14/6)²
}

// NEES of two states over 2: rows of one run, of which one place alone is wrong, or the tails are heavy.
TEST(TailWeight, OfPiecesIsThatOfTheTailsAndNotOfOnePlaceOrTheScale) {
  std::mt19937_64 generator(83);
  std::normal_distribution<double> normal;
  std::student_t_distribution<double> student(5.0);
  const auto run_of = [](auto component) {
    std::vector<double> run(2000);
    for (double& x : run) x = 0.5 * (std::pow(component(), 2) + std::pow(component(), 2));
    return run;
  };
  const auto p_of = [](const std::vector<double>& run) {
    return heavy_tail_p_value(tails_of_pieces(std::span(&run, 1), 2.0));
  };
  constexpr int kStudies = 1000;
  int gaussian = 0, of_one_place = 0, heavy = 0;
  for (int study = 0; study < kStudies; ++study) {
    std::vector<double> run = run_of([&] { return 1.5 * normal(generator); });
    gaussian += p_of(run) <= 0.025;
    for (std::size_t k = 300; k < 400; ++k) run[k] *= 4.0;
    of_one_place += p_of(run) <= 0.025;
    if (study < 100) heavy += p_of(run_of([&] { return student(generator); })) <= 1e-3;
  }
  const double most = 0.025 + 5.0 * test::binomial_standard_error(0.025, kStudies);
  EXPECT_LE(gaussian / 1000.0, most);
  EXPECT_GE(gaussian, 2);
  EXPECT_LE(of_one_place / 1000.0, most);
  EXPECT_GE(heavy, 95);
}

TEST(TailWeight, OfPiecesOfStepsIsThatOfRowsOfOneRun) {
  std::vector<double> run(40);
  std::vector<Moments> steps(40);
  for (std::size_t k = 0; k < run.size(); ++k) {
    run[k] = 0.1 + std::pow(std::sin(static_cast<double>(7 * k + 1)), 4);
    steps[k].add(3.0 * run[k]);
  }
  const SkewedMoments of_rows = tails_of_pieces(std::span(&run, 1), 3.0);
  const SkewedMoments of_steps = tails_of_pieces(steps, 3.0);
  EXPECT_EQ(of_rows.count, 18);
  EXPECT_EQ(of_steps.count, 18);
  EXPECT_NEAR(of_steps.mean, of_rows.mean, 1e-12);
  EXPECT_NEAR(of_steps.m2, of_rows.m2, 1e-12);
}

TEST(TailWeight, TooLittleData) {
  EXPECT_TRUE(std::isnan(heavy_tail_p_value(SkewedMoments{})));
  EXPECT_TRUE(std::isnan(heavy_tail_p_value(TailSums{})));
  EXPECT_TRUE(std::isnan(heavy_tail_p_value({.count = 9, .mean = 1.0, .m2 = 1.0})));
  EXPECT_TRUE(std::isnan(heavy_tail_p_value({.count = 20, .mean = 1.0})));
  const std::vector<double> short_run(19, 1.0);
  EXPECT_EQ(tails_of_pieces(std::span(&short_run, 1), 2.0).count, 0);
  EXPECT_EQ(tails_of_pieces(std::vector<Moments>(40), 2.0).count, 0);
}

}  // namespace
}  // namespace credence::internal
