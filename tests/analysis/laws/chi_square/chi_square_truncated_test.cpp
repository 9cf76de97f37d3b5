#include "analysis/laws/chi_square/chi_square_truncated.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(ChiSquareTruncated, TwoDofAt99PercentHasMean1907) {
  // theory, section 7. By hand: gate g = −2 ln 0.01, mean 2 (1 − (1 + g/2) / 100) / 0.99.
  const double gate = chi_square_quantile(0.99, 2.0);
  const double by_hand = 2.0 * (1.0 - (1.0 + 0.5 * gate) / 100.0) / 0.99;
  EXPECT_NEAR(truncated_chi_square_cumulants(2.0, gate).mean, by_hand, 1e-12);
  EXPECT_NEAR(truncated_chi_square_cumulants(2.0, gate).mean, 1.907, 5e-4);
}

TEST(ChiSquareTruncated, CumulantsAgreeWithQuadrature) {
  for (const double dof : {1.0, 2.0, 3.0, 6.0}) {
    for (const double gate : {0.5 * dof, dof + 3.0, 30.0}) {
      // Midpoint rule in √x, where the density of one dof is smooth.
      constexpr int kCells = 20000;
      double moments[4] = {0.0, 0.0, 0.0, 0.0};
      const double h = std::sqrt(gate) / kCells;
      for (int i = 0; i < kCells; ++i) {
        const double x = std::pow((i + 0.5) * h, 2);
        const double weight = chi_square_density(x, dof) * 2.0 * (i + 0.5) * h * h;
        for (int j = 0; j < 4; ++j) moments[j] += weight * std::pow(x, j);
      }
      const double m1 = moments[1] / moments[0], m2 = moments[2] / moments[0], m3 = moments[3] / moments[0];
      const Cumulants cumulants = truncated_chi_square_cumulants(dof, gate);
      EXPECT_NEAR(cumulants.mean, m1, 1e-8 * m1);
      EXPECT_NEAR(cumulants.variance, m2 - m1 * m1, 1e-7 * m2);
      EXPECT_NEAR(cumulants.third, m3 - 3 * m1 * m2 + 2 * m1 * m1 * m1, 1e-6 * m3);
    }
  }
}

TEST(ChiSquareTruncated, NoGateIsTheWholeLaw) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  EXPECT_NEAR(truncated_chi_square_cumulants(3.0, kInf).variance, 6.0, 1e-12);
  EXPECT_NEAR(truncated_chi_square_cumulants(3.0, kInf).third, 24.0, 1e-12);
  EXPECT_THROW(truncated_chi_square_cumulants(0.0, 2.0), std::invalid_argument);
}

// 20 runs of 50 steps of 2-dimensional innovations that passed the 99 % gate.
std::vector<Moments> gated_study(double gate, std::mt19937_64& generator) {
  std::chi_squared_distribution<double> chi(2.0);
  std::vector<Moments> steps(50);
  for (Moments& step : steps) {
    for (int run = 0; run < 20; ++run) {
      double value = chi(generator);
      while (value > gate) value = chi(generator);
      step.add(value);
    }
  }
  return steps;
}

TEST(ChiSquareTruncated, GatedVerdictIsCalibratedAndThePlainOneIsNot) {
  constexpr int kStudies = 2000;
  const double gate = chi_square_quantile(0.99, 2.0);
  const std::vector<double> dofs(50, 40.0);
  for (const double alpha : {0.05, 0.01}) {
    std::mt19937_64 generator(8);
    int gated = 0;
    int plain = 0;
    for (int study = 0; study < kStudies; ++study) {
      const std::vector<Moments> steps = gated_study(gate, generator);
      gated += judge_gated_nis(steps, 2.0, gate, 1.0 - alpha).verdict != Verdict::consistent;
      plain += judge_nis(steps, dofs, 1.0 - alpha).verdict == Verdict::pessimistic;
    }
    const double error = test::binomial_standard_error(alpha, kStudies);
    EXPECT_NEAR(static_cast<double>(gated) / kStudies, alpha, 5.0 * error);
    EXPECT_GT(static_cast<double>(plain) / kStudies, alpha + 10.0 * error);
  }
}

TEST(ChiSquareTruncated, GatedVerdictSeesAWrongScaleAndDegenerateData) {
  const std::vector<Moments> high(30, Moments{.count = 50, .mean = 2.5, .m2 = 1.0});
  EXPECT_EQ(judge_gated_nis(high, 2.0, 9.21, 0.95).verdict, Verdict::optimistic);
  const std::vector<Moments> low(30, Moments{.count = 50, .mean = 1.6, .m2 = 1.0});
  EXPECT_EQ(judge_gated_nis(low, 2.0, 9.21, 0.95).verdict, Verdict::pessimistic);
  const std::vector<Moments> right(30, Moments{.count = 50, .mean = 1.907, .m2 = 1.0});
  EXPECT_EQ(judge_gated_nis(right, 2.0, 9.21, 0.95).verdict, Verdict::consistent);
  EXPECT_NEAR(judge_gated_nis(right, 2.0, 9.21, 0.95).expected, 1.907, 1e-3);
  EXPECT_EQ(judge_gated_nis({}, 2.0, 9.21, 0.95).verdict, Verdict::undecided);
}

}  // namespace
}  // namespace credence::internal
