#include "analysis/evidence/consistency_correlated.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "analysis/laws/effective_sample.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence {
namespace {

constexpr std::size_t kSteps = 50;

// ‖C_kl‖² of the errors of the scalar filter: φ = (1 − K) at every step.
Matrix exact_correlation(double q, double r) {
  const double prior = 0.5 * (q + std::sqrt(q * q + 4.0 * q * r));
  const double phi = 1.0 - prior / (prior + r);
  const std::vector<Matrix> transitions(kSteps, Matrix::Constant(1, 1, phi));
  const std::vector<Matrix> covariances(kSteps, Matrix::Constant(1, 1, phi * prior));
  return linear_nees_time_law(transitions, covariances).correlation;
}

TEST(CorrelatedNees, HoldsTheNominalRateOnStronglyCorrelatedSteps) {
  // Q/R = 0.0025 again, where judge_nees is conservative: here the rate is the nominal one.
  constexpr int kStudies = 2000;
  constexpr int kRuns = 30;
  const std::vector<double> dofs(kSteps, kRuns);
  const CorrelatedSteps law = correlated_steps(exact_correlation(0.0025, 1.0), dofs);
  const test::ScalarFilter filter(0.0025, 1.0);
  std::mt19937_64 generator(1);
  int alarms[2] = {0, 0};
  for (int study = 0; study < kStudies; ++study) {
    std::vector<Moments> nees(kSteps), nis(kSteps);
    filter.simulate(kRuns, generator, nees, nis);
    const double p = judge_correlated_nees(nees, dofs, law, 0.95).p_value;
    alarms[0] += p <= 0.05;
    alarms[1] += p <= 0.01;
  }
  EXPECT_NEAR(alarms[0] / 2000.0, 0.05, 5.0 * test::binomial_standard_error(0.05, kStudies));
  EXPECT_NEAR(alarms[1] / 2000.0, 0.01, 5.0 * test::binomial_standard_error(0.01, kStudies));
}

TEST(CorrelatedNees, IsSharperThanTheProvedVerdict) {
  constexpr int kRuns = 60;
  const std::vector<double> dofs(kSteps, kRuns);
  const CorrelatedSteps law = correlated_steps(exact_correlation(0.0025, 1.0), dofs);
  const test::ScalarFilter optimistic(0.0025, 1.0, 1.0, 0.5);
  std::mt19937_64 generator(2);
  int sharp = 0;
  int proved = 0;
  for (int study = 0; study < 300; ++study) {
    std::vector<Moments> nees(kSteps), nis(kSteps);
    optimistic.simulate(kRuns, generator, nees, nis);
    sharp += judge_correlated_nees(nees, dofs, law, 0.95).verdict == Verdict::optimistic;
    proved += judge_nees(nees, dofs, 0.95).verdict == Verdict::optimistic;
  }
  EXPECT_GT(sharp, proved);
  EXPECT_GT(sharp, 150);
}

TEST(CorrelatedNees, IndependentStepsGiveSidak) {
  // 50 independent scores and their sum: 5 % of the largest lie above about the Šidák point of 51 tests.
  const CorrelatedSteps law = correlated_steps(Matrix::Identity(50, 50), std::vector<double>(50, 10.0));
  const double at_95 = law.largest_scores[19000];
  const double level = std::erfc(at_95 / std::sqrt(2.0));
  EXPECT_NEAR(level, 1.0 - std::pow(0.95, 1.0 / 51.0), 0.0001);
}

TEST(CorrelatedNees, EqualStepsAreOneTest) {
  const CorrelatedSteps law = correlated_steps(Matrix::Ones(20, 20), std::vector<double>(20, 10.0));
  EXPECT_NEAR(law.largest_scores[19000], 1.96, 0.05);
}

TEST(CorrelatedNees, LawDependsOnTheCorrelationOfTheStepsWithDataAlone) {
  // A step without dof, first or last, leaves every draw to the bit; another correlation does not.
  const Matrix correlation = exact_correlation(0.01, 1.0);
  const auto law = [&](Index first) {
    Matrix wider = Matrix::Identity(kSteps + 1, kSteps + 1);
    wider.block(first, first, kSteps, kSteps) = correlation;
    std::vector<double> dofs(kSteps + 1, 10.0);
    dofs[first == 0 ? kSteps : 0] = 0.0;
    return correlated_steps(wider, dofs).largest_scores;
  };
  const std::vector<double> alone =
      correlated_steps(correlation, std::vector<double>(kSteps, 10.0)).largest_scores;
  EXPECT_EQ(law(0), alone);
  EXPECT_EQ(law(1), alone);
  EXPECT_NE(correlated_steps(exact_correlation(0.02, 1.0), std::vector<double>(kSteps, 10.0)).largest_scores,
            alone);
}

TEST(CorrelatedNees, BoundsAndVerdictAgree) {
  const std::vector<double> dofs(kSteps, 60.0);
  const CorrelatedSteps law = correlated_steps(exact_correlation(0.01, 1.0), dofs);
  for (double mean = 1.0; mean < 3.0; mean += 0.05) {
    const std::vector<Moments> steps(kSteps, Moments{.count = 30, .mean = mean, .m2 = 1.0});
    const ConsistencyVerdict result = judge_correlated_nees(steps, dofs, law, 0.95);
    const bool inside = mean > std::max(result.bounds.lower, result.steps[0].simultaneous_lower) &&
                        mean < std::min(result.bounds.upper, result.steps[0].simultaneous_upper);
    EXPECT_EQ(inside, result.verdict == Verdict::consistent) << mean;
  }
}

TEST(CorrelatedNees, DegenerateAndImpossibleInput) {
  const std::vector<double> dofs{10.0, 0.0, 10.0};
  const CorrelatedSteps law = correlated_steps(Matrix::Identity(3, 3), dofs);
  EXPECT_EQ(law.dofs.size(), 2U);
  const std::vector<Moments> steps(3, Moments{.count = 10, .mean = 1.0, .m2 = 1.0});
  EXPECT_EQ(judge_correlated_nees(steps, dofs, law, 0.95).verdict, Verdict::consistent);
  std::vector<Moments> fewer = steps;
  fewer[0].count = 0;
  EXPECT_EQ(judge_correlated_nees(fewer, dofs, law, 0.95).verdict,
            Verdict::consistent);  // one step: no joint law
  const std::vector<double> all(3, 10.0);
  EXPECT_THROW(judge_correlated_nees(steps, all, law, 0.95), std::invalid_argument);
  EXPECT_THROW(correlated_steps(Matrix::Identity(2, 2), dofs), std::invalid_argument);
  EXPECT_THROW(correlated_steps(3.0 * Matrix::Identity(3, 3), dofs), std::invalid_argument);
  const CorrelatedSteps empty = correlated_steps(Matrix(0, 0), {});
  EXPECT_EQ(judge_correlated_nees({}, {}, empty, 0.95).verdict, Verdict::undecided);
}

}  // namespace
}  // namespace credence
