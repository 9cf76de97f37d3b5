#include "analysis/stability/exact_moments.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "analysis/stability/ranks.h"
#include "analysis/stability/riccati.h"
#include "core/filters/linear_estimators.h"
#include "core/filters/linear_filter.h"

namespace credence::internal {
namespace {

std::vector<LinearFilterStep> filter_steps(const LinearModel& model, Inflation inflation, Index steps) {
  InflationRule rule;
  rule.inflation = inflation;
  rule.solution = InflationSolution::pairwise;
  return linear_filter_steps(model, rule, steps);
}

struct Reference {
  Index landmarks, anchors;
  Inflation inflation;
  double trace_prior, trace, vehicle, landmark, gain, nees, nis;
  Index rank_inflation, rank_noise;
  std::vector<double> eigenvalues;  // of F − K H, rising; six digits
};

// theory, section 6, after the update of step 100.
const Reference kReferences[] = {
    {1, 0, Inflation::none, 1.236649890, 1.136649890, 0.599226644, 0.537423246, 0, 2, 1, 0, 1, {0.381966, 1}},
    {1,
     0,
     Inflation::full,
     11.817165939,
     5.957736652,
     2.979291469,
     2.978445182,
     0.491572936,
     1.976957769,
     0.025033555,
     1,
     2,
     {0.008391, 1}},
    {1,
     1,
     Inflation::none,
     0.139121585,
     0.039096455,
     0.037101323,
     0.001995132,
     0.009975660,
     2,
     2,
     0,
     1,
     {0.267949, 0.990024}},
    {1,
     1,
     Inflation::full,
     0.223606798,
     0.089442719,
     0.044721360,
     0.044721360,
     0.276393202,
     1.636610019,
     1.726779962,
     1,
     2,
     {0.218611, 0.781389}},
    {2,
     0,
     Inflation::none,
     1.179345194,
     1.079335114,
     0.383847064,
     0.347744025,
     0.004995005,
     3,
     2,
     0,
     1,
     {0.267949, 0.990010, 1}},
    {2,
     0,
     Inflation::full,
     12.705589127,
     4.365422020,
     1.433954337,
     1.465733842,
     0.651148708,
     2.947689567,
     0.076303405,
     2,
     3,
     {0.007748, 0.023247, 1}},
    {2,
     0,
     Inflation::map,
     1.872825161,
     1.165749407,
     0.383847064,
     0.390951171,
     0.437066470,
     2.888204333,
     1.223591335,
     1,
     2,
     {0.125867, 0.267949, 1}},
};

TEST(ExactMoments, ReferenceTable) {
  for (const Reference& reference : kReferences) {
    SCOPED_TRACE(::testing::Message() << "N " << reference.landmarks << " anchors " << reference.anchors
                                      << " inflation " << static_cast<int>(reference.inflation));
    const LinearModel model = monobot_model(reference.landmarks, reference.anchors, 0.1, 0.1, 1.0);
    const auto steps = filter_steps(model, reference.inflation, 100);
    ASSERT_EQ(steps.size(), 100U);
    const LinearFilterStep& last = steps.back();
    EXPECT_NEAR(last.P_prior.trace(), reference.trace_prior, 1e-8);
    EXPECT_NEAR(last.P.trace(), reference.trace, 1e-8);
    EXPECT_NEAR(last.P(0, 0), reference.vehicle, 1e-8);
    EXPECT_NEAR(last.P(1, 1), reference.landmark, 1e-8);
    EXPECT_NEAR(last.K(1, reference.anchors), reference.gain, 1e-8);

    const ExactMoments moments = exact_moments(model, steps).back();
    EXPECT_NEAR(moments.nees, reference.nees, 2e-9);
    EXPECT_NEAR(moments.nis, reference.nis, 2e-9);
    EXPECT_EQ(moments.nees_dof, model.state_dim());
    EXPECT_EQ(moments.nis_dof, model.measurement_dim());
    EXPECT_LT(moments.outside, 1e-12);

    EXPECT_EQ(psd_rank(last.inflation).rank, reference.rank_inflation);
    const Matrix Qt = model.G * model.Q * model.G.transpose() + last.inflation;
    EXPECT_EQ(psd_rank(Qt).rank, reference.rank_noise);
    Eigen::VectorXcd eigenvalues = closed_loop_eigenvalues(model.F, last.K, model.H);
    ASSERT_EQ(eigenvalues.size(), static_cast<Index>(reference.eigenvalues.size()));
    for (Index i = 0; i < eigenvalues.size(); ++i) {
      const double expected =
          reference.eigenvalues[reference.eigenvalues.size() - 1 - static_cast<std::size_t>(i)];
      EXPECT_NEAR(std::abs(eigenvalues[i] - expected), 0.0, 1e-6);
    }
  }
}

TEST(ExactMoments, OfTheOptimalFilterAreItsOwnCovariance) {
  const LinearModel model = monobot_model(3, 1, 0.2, 0.3, 0.7);
  const auto steps = filter_steps(model, Inflation::none, 30);
  const auto moments = exact_moments(model, steps);
  ASSERT_EQ(moments.size(), 30U);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    EXPECT_LT((moments[k].Sigma - steps[k].P).norm(), 1e-13);
    EXPECT_NEAR(moments[k].nees, 4.0, 1e-10);
    EXPECT_NEAR(moments[k].nis, 4.0, 1e-10);
  }
}

TEST(ExactMoments, OfAMistunedScalarFilterByHand) {
  // One step of x⁺ = x + v, z = x + w: the filter assumes R = 3, the truth is R = 1, Q = 1, P0 = 1.
  LinearModel truth;
  truth.F = truth.G = truth.Q = truth.H = truth.R = truth.P0 = Matrix::Ones(1, 1);
  LinearModel assumed = truth;
  assumed.R(0, 0) = 3.0;
  const auto moments = exact_moments(truth, filter_steps(assumed, Inflation::none, 1));
  // K = 2/5, P = 6/5, Σ = (3/5)² 2 + (2/5)² = 22/25; S = 5, E νν = 3.
  EXPECT_NEAR(moments[0].Sigma(0, 0), 0.88, 1e-15);
  EXPECT_NEAR(moments[0].nees, 0.88 / 1.2, 1e-15);
  EXPECT_NEAR(moments[0].nis, 0.6, 1e-15);
}

TEST(ExactMoments, AgreeWithMonteCarlo) {
  const LinearModel model = monobot_model(2, 0, 0.1, 0.1, 1.0);
  const auto steps = filter_steps(model, Inflation::map, 10);
  const ExactMoments exact = exact_moments(model, steps).back();
  std::mt19937_64 generator(77);
  std::normal_distribution<double> normal;
  constexpr int kRuns = 20000;
  double sum = 0.0, sum_of_squares = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    Vector error(3);
    for (double& entry : error) entry = normal(generator);
    for (const LinearFilterStep& step : steps) {
      error[0] += std::sqrt(0.1) * normal(generator);
      Vector w(2);
      for (double& entry : w) entry = std::sqrt(0.1) * normal(generator);
      error = error - step.K * (model.H * error + w);
    }
    const double nees = error.dot(steps.back().P.llt().solve(error));
    sum += nees;
    sum_of_squares += nees * nees;
  }
  const double mean = sum / kRuns;
  const double standard_error = std::sqrt((sum_of_squares / kRuns - mean * mean) / kRuns);
  EXPECT_LT(std::abs(mean - exact.nees), 5.0 * standard_error)
      << "low " << exact.nees - 5.0 * standard_error << " got " << mean << " high "
      << exact.nees + 5.0 * standard_error;
  EXPECT_GT(std::abs(mean - 3.0), 5.0 * standard_error);  // the power: it is not the consistent filter
}

TEST(ExactMoments, SingularCovarianceLowersTheDof) {
  LinearModel model = monobot_model(2, 0, 0.1, 0.1, 1.0);
  model.P0(2, 2) = 0.0;  // the second landmark is known
  const ExactMoments moments = exact_moments(model, filter_steps(model, Inflation::none, 5)).back();
  EXPECT_EQ(moments.nees_dof, 2);
  EXPECT_NEAR(moments.nees, 2.0, 1e-10);
  EXPECT_EQ(moments.outside, 0.0);
  EXPECT_EQ(moments.nis_dof, 2);
}

TEST(ExpectedSquare, CorrelatedSingularCovariance) {
  // P = v vᵀ; Σ has twice the variance along v and something across it.
  const Eigen::Vector2d v(3.0, 4e-4);
  const Matrix P = v * v.transpose();
  ExpectedSquare square = expected_square(P, 2.0 * P);
  EXPECT_EQ(square.dof, 1);
  EXPECT_NEAR(square.value, 2.0, 1e-12);
  EXPECT_LT(square.outside, 1e-12);
  Matrix Sigma = 2.0 * P;
  Sigma(1, 1) *= 1.5;
  square = expected_square(P, Sigma);
  EXPECT_EQ(square.dof, 1);
  EXPECT_GT(square.outside, 0.01);  // error where the filter claims certainty
  EXPECT_EQ(expected_square(Matrix::Zero(2, 2), Sigma).dof, 0);
  EXPECT_EQ(expected_square(Matrix::Zero(2, 2), Sigma).outside, 1.0);
}

TEST(ExactMoments, EndsAtAStepThatFailed) {
  const LinearModel model = monobot_model(1, 0, 0.1, 0.1, 1.0);
  auto steps = filter_steps(model, Inflation::none, 5);
  steps[3].ok = false;
  EXPECT_EQ(exact_moments(model, steps).size(), 3U);
}

TEST(ExactMoments, StepsOfAnotherModelAreRefused) {
  const auto steps = filter_steps(monobot_model(2, 0, 0.1, 0.1, 1.0), Inflation::none, 2);
  EXPECT_THROW(exact_moments(monobot_model(3, 0, 0.1, 0.1, 1.0), steps), std::invalid_argument);
}

// Joseph's form is the covariance of the error whatever the gain: NEES is n where the noise is known, and
// what Monte Carlo measures where it is not.
TEST(ExactMoments, HoldForAnyGain) {
  const LinearModel model = monobot_model(2, 1, 0.1, 0.1, 1.0);
  const Matrix K = (Matrix(3, 3) << -0.5, 0.1, 0.1, -0.1, 0.4, 0, -0.1, 0, 0.4).finished();
  const std::vector<Index> considered = {2};
  for (const auto& steps : {constant_gain_steps(model, K, 60), consider_steps(model, considered, 60)}) {
    for (const ExactMoments& moments : exact_moments(model, steps)) EXPECT_NEAR(moments.nees, 3.0, 1e-9);
  }
  LinearModel wrong = model;
  wrong.Q *= 0.1;
  EXPECT_GT(exact_moments(model, constant_gain_steps(wrong, K, 60)).back().nees, 3.1);
}

}  // namespace
}  // namespace credence::internal
