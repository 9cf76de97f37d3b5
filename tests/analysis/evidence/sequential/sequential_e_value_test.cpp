#include "analysis/evidence/sequential/sequential_e_value.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// ∫ E(S + x, D + 2) ½ e^{−x/2} dx over x = t/(1 − t), by the midpoint rule.
double mean_after_one_more(double sum, double dof) {
  constexpr int kCells = 40'000;
  double mean = 0.0;
  for (int i = 0; i < kCells; ++i) {
    const double t = (i + 0.5) / kCells;
    const double x = t / (1.0 - t);
    mean += 0.5 * std::exp(log_e_value(sum + x, dof + 2.0) - 0.5 * x) / ((1.0 - t) * (1.0 - t) * kCells);
  }
  return mean;
}

TEST(SequentialEValue, IsAMartingaleAlongTheRuns) {
  // What a run of two dof adds has mean one, whatever came before.
  for (const auto& [sum, dof] : {std::pair{0.0, 0.0}, {7.0, 6.0}, {90.0, 60.0}, {20.0, 40.0}}) {
    EXPECT_NEAR(mean_after_one_more(sum, dof) / std::exp(log_e_value(sum, dof)), 1.0, 1e-4) << sum;
  }
}

TEST(SequentialEValue, OfStepsIsTheMeanOfTheirs) {
  const std::vector<Moments> steps{{.count = 4, .mean = 3.0, .m2 = 1.0}, {.count = 5, .mean = 0.5}, {}};
  const std::vector<double> dofs{8.0, 15.0, 0.0};
  const double first = std::exp(log_e_value(12.0, 8.0)), second = std::exp(log_e_value(2.5, 15.0));
  const double mean = (first + second + 1.0) / 3.0;
  EXPECT_NEAR(log_e_nees(steps, dofs), std::log(mean), 1e-13);
  EXPECT_NEAR(log_e_nis(steps, dofs), std::log(0.5 * (mean + std::exp(log_e_value(14.5, 23.0)))), 1e-13);
  EXPECT_EQ(log_e_nees({}, {}), 0.0);
  EXPECT_EQ(log_e_nis({}, {}), 0.0);
}

/// Shares of studies of 100 runs of five steps, of two dof each, in which the e-values ever reach 20.
struct Reached {
  double nees = 0.0, nis = 0.0;
};
Reached ever_reached(bool equal_steps, double factor, int studies, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::chi_squared_distribution<double> chi(2.0);
  Reached reached;
  for (int study = 0; study < studies; ++study) {
    std::vector<Moments> steps(5);
    bool nees = false, nis = false;
    for (int run = 1; run <= 100; ++run) {
      const double common = chi(generator);
      for (Moments& step : steps) step.add(factor * (equal_steps ? common : chi(generator)));
      const std::vector<double> dofs(5, 2.0 * run);
      nees = nees || log_e_nees(steps, dofs) >= std::log(20.0);
      nis = nis || log_e_nis(steps, dofs) >= std::log(20.0);
    }
    reached.nees += nees ? 1.0 / studies : 0.0;
    reached.nis += nis ? 1.0 / studies : 0.0;
  }
  return reached;
}

TEST(SequentialEValue, KeepsVillesBoundAtEveryLook) {
  constexpr int kStudies = 500;
  const double most = 0.05 + 5.0 * test::binomial_standard_error(0.05, kStudies);
  const Reached white = ever_reached(false, 1.0, kStudies, 31);
  EXPECT_LE(white.nees, most);
  EXPECT_LE(white.nis, most);
  const Reached equal = ever_reached(true, 1.0, kStudies, 32);
  EXPECT_LE(equal.nees, most) << "valid for any correlation of the steps";
  EXPECT_GT(equal.nis, most) << "the sum over steps needs white ones";
}

TEST(SequentialEValue, FindsAFactorInEitherDirection) {
  for (const double factor : {1.6, 1.0 / 1.6}) {
    const Reached reached = ever_reached(false, factor, 100, 33);
    EXPECT_GT(reached.nees, 0.5) << factor;
    EXPECT_GT(reached.nis, 0.95) << factor;
  }
}

TEST(SequentialEValue, ShareOfLawIsThatOfTheVarianceOfChiSquare) {
  // Two dof and mean 3: χ² of this mean has the variance 2 · 9 / 2; two runs of 3 ± a have 2 a².
  const auto of = [](double a) {
    return share_of_law(std::vector<Moments>{{.count = 2, .mean = 3.0, .m2 = 2.0 * a * a}, {}},
                        std::vector{4.0, 0.0});
  };
  EXPECT_EQ(of(0.5), 1.0);
  EXPECT_DOUBLE_EQ(of(3.0), 0.5);
  EXPECT_EQ(of(kInfinite), 1.0);
  EXPECT_EQ(share_of_law({}, {}), 1.0);
  EXPECT_THROW(share_of_law({}, std::vector{1.0}), std::invalid_argument);
  EXPECT_EQ(discounted(-2.0, 0.5), -2.0);
  EXPECT_EQ(discounted(2.0, 0.5), 1.0);
}

// A sum of 64 runs that is by far too large is evidence where all are, and none where one of them is.
TEST(SequentialEValue, OneHugeValueIsNoEvidence) {
  constexpr int kRuns = 64;
  Moments all, one, right;
  for (int i = 0; i < kRuns; ++i) {
    const double of_law = i % 2 == 0 ? 1.0 - std::numbers::sqrt2 / 2.0 : 1.0 + std::numbers::sqrt2 / 2.0;
    right.add(of_law);
    all.add(4.0 * of_law);
    one.add(i == 20 ? 190.0 : of_law);
  }
  const std::vector<double> dofs(20, kRuns);
  const auto evidence = [&](const Moments& at_one_step, const auto& log_e) {
    std::vector<Moments> steps(20, right);
    steps[7] = at_one_step;
    return log_e(steps, dofs);
  };
  EXPECT_GT(evidence(all, log_e_nees), 10.0);
  EXPECT_GT(evidence(all, log_e_nis), 10.0);
  EXPECT_LT(evidence(one, log_e_nees), 1.0);
  EXPECT_LT(evidence(one, log_e_nis), 1.0);
}

TEST(SequentialEValue, OfBadSumsIsNoEvidenceOrInfinite) {
  const std::vector<double> dofs{4.0, 4.0};
  const Moments right{.count = 2, .mean = 2.0};
  const auto of = [&](double mean) {
    return log_e_nees(std::vector<Moments>{right, {.count = 2, .mean = mean}}, dofs);
  };
  EXPECT_TRUE(std::isnan(of(std::nan(""))));
  EXPECT_TRUE(std::isnan(of(-1.0)));
  EXPECT_EQ(of(kInfinite), kInfinite);
  EXPECT_THROW(log_e_nees(std::vector<Moments>{right}, dofs), std::invalid_argument);
  EXPECT_THROW(log_e_nis(std::vector<Moments>{right}, dofs), std::invalid_argument);
  EXPECT_THROW(log_e_value(1.0, kInfinite), std::invalid_argument);
  EXPECT_THROW(log_e_value(1.0, std::nan("")), std::invalid_argument);
}

/// The evidence against the covariance `factor` P.
double log_e_against(std::vector<Moments> steps, const std::vector<double>& dofs, double factor) {
  for (Moments& step : steps) step.mean /= factor;
  return log_e_nees(steps, dofs);
}

TEST(ScaleConfidenceSequence, EndsWhereTheEvidenceReachesItsBar) {
  const std::vector<Moments> steps{{.count = 60, .mean = 3.1}, {.count = 60, .mean = 2.6}, {}};
  const std::vector<double> dofs{120.0, 120.0, 0.0};
  for (const double confidence : {0.9, 0.99}) {
    const ChiSquareBounds scale = scale_confidence_sequence(steps, dofs, confidence);
    const double bar = -std::log(1.0 - confidence);
    EXPECT_NEAR(log_e_against(steps, dofs, scale.lower), bar, 1e-6);
    EXPECT_NEAR(log_e_against(steps, dofs, scale.upper), bar, 1e-6);
    EXPECT_LT(log_e_against(steps, dofs, std::sqrt(scale.lower * scale.upper)), bar);
    EXPECT_GT(scale.lower, 0.8);
    EXPECT_LT(scale.upper, 3.0);
  }
}

TEST(ScaleConfidenceSequence, MovesWithTheFactor) {
  std::vector<Moments> steps{{.count = 60, .mean = 3.1}, {.count = 60, .mean = 2.6}};
  const std::vector<double> dofs{120.0, 120.0};
  const ChiSquareBounds scale = scale_confidence_sequence(steps, dofs, 0.95);
  for (const double factor : {1e-9, 1e9}) {
    std::vector<Moments> scaled = steps;
    for (Moments& step : scaled) step.mean *= factor;
    const ChiSquareBounds moved = scale_confidence_sequence(scaled, dofs, 0.95);
    EXPECT_NEAR(moved.lower / (factor * scale.lower), 1.0, 1e-8);
    EXPECT_NEAR(moved.upper / (factor * scale.upper), 1.0, 1e-8);
  }
}

TEST(ScaleConfidenceSequence, HasNoUpperEndWhereErrorsOfZeroWouldNotRefuteIt) {
  // E of no error at all is Γ(a + d/2)/(Γ(a) a^{d/2}): 1 for two dof, far above 20 for forty.
  const std::vector<Moments> few{{.count = 1, .mean = 2.0}}, many{{.count = 20, .mean = 2.0}};
  EXPECT_EQ(scale_confidence_sequence(few, std::vector{2.0}, 0.95).upper, kInfinite);
  EXPECT_LT(scale_confidence_sequence(many, std::vector{40.0}, 0.95).upper, 3.0);
}

TEST(ScaleConfidenceSequence, SaysWhatItCannotTell) {
  const std::vector<double> dofs{4000.0, 4000.0};
  const auto of = [&](double first, double second) {
    const std::vector<Moments> steps{{.count = 2000, .mean = first}, {.count = 2000, .mean = second}};
    return scale_confidence_sequence(steps, dofs, 0.95);
  };
  EXPECT_TRUE(std::isnan(of(2.0, 20.0).lower)) << "no common factor";
  EXPECT_TRUE(std::isnan(of(2.0, 20.0).upper));
  EXPECT_TRUE(std::isnan(of(2.0, kInfinite).lower));
  EXPECT_TRUE(std::isnan(of(2.0, std::nan("")).upper));
  EXPECT_TRUE(std::isnan(of(2.0, -2.0).upper));
  const ChiSquareBounds nothing = scale_confidence_sequence({}, {}, 0.95);
  EXPECT_EQ(nothing.lower, 0.0);
  EXPECT_EQ(nothing.upper, kInfinite);
  EXPECT_THROW(scale_confidence_sequence({}, {}, 1.0), std::invalid_argument);
  EXPECT_THROW(scale_confidence_sequence({}, dofs, 0.95), std::invalid_argument);
}

TEST(ScaleConfidenceSequence, FindsAFactorFarFromTheMean) {
  // One run, one outlier: a factor of 1e5 and more is not refuted.
  std::vector<Moments> steps(20'000, Moments{.count = 1, .mean = 3.0});
  steps[7].mean = 1e6;
  const std::vector<double> dofs(steps.size(), 3.0);
  const ChiSquareBounds scale = scale_confidence_sequence(steps, dofs, 0.95);
  EXPECT_GT(scale.lower, 1e4);
  EXPECT_LT(scale.lower, 1e5);
  EXPECT_EQ(scale.upper, HUGE_VAL);
}

}  // namespace
}  // namespace credence::internal
