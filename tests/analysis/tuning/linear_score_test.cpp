#include "analysis/tuning/linear_score.h"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <atomic>
#include <cmath>
#include <numbers>

#include "core/stop_point.h"
#include "tests/analysis/tuning/local_level.h"

namespace credence::internal {
namespace {

using testing::local_level;
using testing::simulate;
using testing::survey_model;

LinearModel three_states() {
  LinearModel model = survey_model();
  model.F = Matrix(3, 3);
  model.F << 1.0, 0.1, 0.0, 0.0, 0.95, 0.2, 0.0, 0.0, 0.8;
  model.G = Matrix(3, 2);
  model.G << 0.0, 0.1, 1.0, 0.0, 0.0, 1.0;
  model.H = Matrix(2, 3);
  model.H << 1.0, 0.0, 0.0, 0.5, 1.0, 0.0;
  model.P0 = Vector{{1.0, 2.0, 0.5}}.asDiagonal();
  model.layout = {.vehicle = 3, .landmark = 0, .landmarks = 0};
  return model;
}

TEST(LinearScore, IsTheDensityOfTheWholeRecord) {
  const LinearModel model = local_level(0.3, 2.0);
  const std::vector<MeasuredRun> runs = simulate(model, 1, 4, 3);
  const LinearScore score({model, parse_free_noise("Q")}, runs);
  Matrix covariance(4, 4);  // of z: P0 + min(k, l) q + r on the diagonal
  for (Index k = 0; k < 4; ++k) {
    for (Index l = 0; l < 4; ++l) {
      covariance(k, l) = 1.0 + 0.3 * static_cast<double>(std::min(k, l) + 1) + (k == l ? 2.0 : 0.0);
    }
  }
  const Vector z = runs.front().z.row(0);
  const double expected = -0.5 * (4.0 * std::log(2.0 * std::numbers::pi) +
                                  std::log(covariance.determinant()) + z.dot(covariance.inverse() * z));
  const UnitScores scores = score.scores(Vector::Zero(1), false);
  ASSERT_TRUE(scores.ok);
  EXPECT_NEAR(scores.sum(), expected, 1e-12);
}

TEST(LinearScore, GradientIsThatOfDifferences) {
  const LinearModel truth = three_states();
  for (const char* free : {"Q,R,P0", "full(Q),diag(R),diag(P0)", "full(R),full(P0),Q"}) {
    const LinearScore score({truth, parse_free_noise(free)}, simulate(truth, 3, 60, 5));
    Vector phi = score.noise().start();
    for (Index i = 0; i < phi.size(); ++i) phi[i] += 0.1 * static_cast<double>(i + 1) - 0.2;
    const Vector gradient = score.scores(phi, true).gradient.rowwise().sum();
    constexpr double h = 1e-5;
    for (Index i = 0; i < phi.size(); ++i) {
      Vector more = phi, less = phi;
      more[i] += h;
      less[i] -= h;
      const double slope = (score.scores(more, false).sum() - score.scores(less, false).sum()) / (2.0 * h);
      EXPECT_NEAR(gradient[i], slope, 1e-6 * (1.0 + std::abs(slope))) << free << ", coordinate " << i;
    }
  }
}

TEST(LinearScore, SettledStepsAreThoseOfTheRecursion) {
  // The settled filter of 5,000 steps against its first 100: no jump where it settles.
  const LinearModel model = survey_model();
  const LinearScore score({model, parse_free_noise("full(Q),diag(R)")}, simulate(model, 1, 5000, 8));
  const InnovationSensitivities filter(model, score.noise().derivatives(score.noise().start()), 5000);
  const InnovationSensitivities brief(model, score.noise().derivatives(score.noise().start()), 100);
  EXPECT_NEAR(filter.step(4999).log_determinant, brief.step(99).log_determinant, 1e-12);
  EXPECT_LT((filter.step(4999).FK_dot - brief.step(99).FK_dot).cwiseAbs().maxCoeff(), 1e-11);
}

/// Covariance of the unit scores against the expected information.
TEST(LinearScore, ExpectedInformationIsTheVarianceOfTheScore) {
  const LinearModel model = survey_model();
  constexpr Index kRuns = 4000;
  const LinearScore score({model, parse_free_noise("full(Q),diag(R),P0")}, simulate(model, kRuns, 30, 17));
  const Matrix expected = score.expected_information(score.noise().start());
  const Matrix gradient = score.scores(score.noise().start(), true).gradient;
  const Vector deviation = expected.diagonal().cwiseSqrt();
  // A score summed over 30 steps is nearly normal: the variance of a product of two is at most 2, and 3 with
  // the kurtosis that is left.
  const double bound = 5.0 * std::sqrt(3.0 / kRuns);
  for (Index i = 0; i < gradient.rows(); ++i) {
    EXPECT_NEAR(gradient.row(i).sum() / deviation[i], 0.0, 5.0) << i;
    for (Index j = 0; j <= i; ++j) {
      const double measured = gradient.row(i).dot(gradient.row(j));
      EXPECT_NEAR(measured / (deviation[i] * deviation[j]), expected(i, j) / (deviation[i] * deviation[j]),
                  bound)
          << i << ", " << j;
    }
  }
}

/// Steps until q and r are known to ±10 %: the bound of the spectral likelihood [Whittle 1953].
TEST(LinearScore, InformationIsWhittlesBound) {
  struct Case {
    double ratio, steps_q, steps_r;
  };
  // 100 times the diagonal of the inverse of ½ mean(∂_i ln f ∂_j ln f), f = q + r (2 − 2 cos ω), by the
  // midpoint rule with 400,000 frequencies.
  for (const Case& c : {Case{1.0, 1094.43, 785.41},
                        {0.1, 2761.25, 287.733},
                        {0.01, 8209.99, 222.130},
                        {0.001, 25501.38, 206.529}}) {
    const LinearModel model = local_level(c.ratio, 1.0);
    const InnovationSensitivities filter(
        model, NoiseParameters(model, parse_free_noise("Q,R")).derivatives(Vector::Zero(2)), 10000);
    constexpr double kSteps = 1e6;
    const Matrix covariance = filter.expected_information(static_cast<Index>(kSteps)).inverse();
    EXPECT_NEAR(kSteps * covariance(0, 0) / 0.01 / c.steps_q, 1.0, 2e-4) << c.ratio;
    EXPECT_NEAR(kSteps * covariance(1, 1) / 0.01 / c.steps_r, 1.0, 2e-4) << c.ratio;
  }
}

TEST(LinearScore, SameBitsForAnyThreads) {
  const LinearModel model = survey_model();
  const auto runs = simulate(model, 100, 20, 2);
  const NoiseParameters noise(model, parse_free_noise("Q,R"));
  const UnitScores one = LinearScore(noise, runs, 1).scores(Vector::Zero(2), true);
  const UnitScores four = LinearScore(noise, runs, 4).scores(Vector::Zero(2), true);
  EXPECT_EQ(one.value, four.value);
  EXPECT_EQ(one.gradient, four.gradient);
}

TEST(LinearScore, EndsWhereItIsToldTo) {
  const LinearModel model = survey_model();
  const std::atomic<bool> go_on{false}, stop{true};
  const auto runs = simulate(model, 100, 20, 2);
  const NoiseParameters noise(model, parse_free_noise("Q,R"));
  EXPECT_NO_THROW(LinearScore(noise, runs, 1, &go_on).scores(Vector::Zero(2), true));
  LinearScore score(noise, runs, 1, &stop);
  EXPECT_THROW(score.scores(Vector::Zero(2), true), Stopped);
  score.forget_stop();
  EXPECT_NO_THROW(score.scores(Vector::Zero(2), true));
}

TEST(LinearScore, RefusesWhatDoesNotFit) {
  const LinearModel model = local_level(1.0, 1.0);
  const NoiseParameters noise(model, parse_free_noise("Q"));
  EXPECT_THROW(LinearScore(noise, {}), std::invalid_argument);
  EXPECT_THROW(LinearScore(noise, simulate(survey_model(), 1, 5, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
