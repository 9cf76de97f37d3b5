#include "core/filters/linear_estimators.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>
#include <stdexcept>
#include <string>

namespace credence::internal {
namespace {

/// A system whose every covariance is positive definite.
LinearModel regular_model() {
  LinearModel model;
  model.F = (Matrix(3, 3) << 1, 0.1, 0, 0, 0.95, -0.5, 0, 0, 0.9).finished();
  model.G = Matrix::Identity(3, 3);
  model.H = (Matrix(2, 3) << 1, 0, 0, 1, 1, 0).finished();
  model.Q = (Matrix(3, 3) << 0.2, 0.1, 0, 0.1, 0.3, 0, 0, 0, 0.1).finished();
  model.R = (Matrix(2, 2) << 1, 0.2, 0.2, 0.5).finished();
  model.P0 = (Matrix(3, 3) << 4, 1, 0, 1, 4, 0, 0, 0, 2).finished();
  model.layout = {.vehicle = 3, .landmark = 0, .landmarks = 0};
  return model;
}

/// What z_1 … z_T tell of x_0 … x_T at once, from x_0 ~ N(0, P0): the solution of the normal equations.
struct WholeBatch {
  Matrix covariance;
  Vector estimate;
};

WholeBatch batch_of(const LinearModel& model, const std::vector<Vector>& z) {
  const Index n = model.state_dim(), T = std::ssize(z);
  Matrix A = Matrix::Zero(n * (T + 1), n * (T + 1));
  Vector b = Vector::Zero(A.rows());
  const Matrix Q = (model.G * model.Q * model.G.transpose()).inverse(), R = model.R.inverse();
  A.topLeftCorner(n, n) = model.P0.inverse();
  for (Index k = 1; k <= T; ++k) {
    Matrix step(n, 2 * n);
    step << -model.F, Matrix::Identity(n, n);
    A.block((k - 1) * n, (k - 1) * n, 2 * n, 2 * n) += step.transpose() * Q * step;
    A.block(k * n, k * n, n, n) += model.H.transpose() * R * model.H;
    b.segment(k * n, n) += model.H.transpose() * R * z[static_cast<std::size_t>(k - 1)];
  }
  WholeBatch batch;
  batch.covariance = A.inverse();
  batch.estimate = batch.covariance * b;
  return batch;
}

TEST(LinearEstimators, TheSmootherIsTheBatchLeastSquares) {
  const LinearModel model = regular_model();
  constexpr Index T = 25, n = 3;
  std::mt19937_64 bits(5);
  std::normal_distribution<double> normal;
  std::vector<Vector> z;
  for (Index k = 0; k < T; ++k) z.push_back(Vector::NullaryExpr(2, [&] { return 3.0 * normal(bits); }));

  const auto steps = linear_filter_steps(model, {}, T);
  std::vector<Vector> estimates = {Vector::Zero(n)};
  for (Index k = 0; k < T; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const Vector prior = model.F * estimates.back();
    estimates.push_back(prior + steps[at].K * (z[at] - model.H * prior));
  }
  const RtsSmoother smoother(model, steps);
  smoother.smooth(estimates);
  const WholeBatch batch = batch_of(model, z);
  for (Index k = 0; k <= T; ++k) {
    const auto at = static_cast<std::size_t>(k);
    EXPECT_LT((estimates[at] - batch.estimate.segment(k * n, n)).norm(), 1e-10) << k;
    EXPECT_LT((smoother.covariance(at) - batch.covariance.block(k * n, k * n, n, n)).norm(), 1e-10) << k;
  }
  EXPECT_THROW(smoother.smooth({estimates.data(), 3}), std::invalid_argument);
}

// A state without noise is known at all times as well as at the end, though P⁻ is singular there.
TEST(LinearEstimators, TheSmootherStandsASingularCovariance) {
  LinearModel model = regular_model();
  model.Q.row(2).setZero();
  model.Q.col(2).setZero();
  model.P0.row(2).setZero();
  model.P0.col(2).setZero();
  const auto steps = linear_filter_steps(model, {}, 10);
  const RtsSmoother smoother(model, steps);
  for (std::size_t k = 0; k <= 10; ++k) {
    EXPECT_TRUE(smoother.covariance(k).allFinite());
    EXPECT_EQ(smoother.covariance(k).row(2).norm(), 0.0);
    if (k > 0) {
      EXPECT_LE(smoother.covariance(k).trace(), steps[k - 1].P.trace() * (1.0 + 1e-12));
    }
  }
}

// Of a step that failed there is no P to smooth.
TEST(LinearEstimators, TheSmootherNamesAStepThatFailed) {
  LinearModel model = regular_model();
  model.Q.setZero();
  model.R.setZero();
  model.P0.setZero();
  const auto steps = linear_filter_steps(model, {}, 10);
  ASSERT_FALSE(steps.back().ok);
  try {
    const RtsSmoother smoother(model, steps);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what()),
              "a smoother needs an S that is positive definite at every step: that of step 1 is not");
  }
}

TEST(LinearEstimators, TheGainOfTheKalmanFilterGivesTheKalmanFilter) {
  const LinearModel model = regular_model();
  const auto kalman = linear_filter_steps(model, {}, 200);
  const auto considered = consider_steps(model, {}, 200);
  for (std::size_t k = 0; k < 200; ++k) EXPECT_LT((kalman[k].P - considered[k].P).norm(), 1e-12);

  const Matrix K = steady_state_gain(model);
  EXPECT_LT((K - kalman.back().K).norm(), 1e-12);
  const auto steady = constant_gain_steps(model, K, 200);
  EXPECT_LT((steady.back().P - kalman.back().P).norm(), 1e-12);
  // Another gain than the best is worse at every step.
  for (std::size_t k = 0; k < 200; ++k) EXPECT_GE(steady[k].P.trace(), kalman[k].P.trace() * (1.0 - 1e-12));
}

TEST(LinearEstimators, AConsideredStateKeepsItsVariance) {
  const LinearModel model = regular_model();
  const std::vector<Index> load = {2};
  Matrix P = model.P0;
  for (const LinearFilterStep& step : consider_steps(model, load, 30)) {
    P = model.F * P * model.F.transpose() + model.Q;
    EXPECT_TRUE(step.K.row(2).isZero());
    EXPECT_NEAR(step.P(2, 2), P(2, 2), 1e-12);
    P = step.P;
  }
}

TEST(LinearEstimators, AGainThatNeverSettlesIsRefused) {
  LinearModel constant = regular_model();  // its gain falls as 1/k
  constant.F.setIdentity();
  constant.Q.setZero();
  EXPECT_THROW(steady_state_gain(constant), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
