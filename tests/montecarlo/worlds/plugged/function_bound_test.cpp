#include "montecarlo/worlds/plugged/function_bound.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <utility>
#include <vector>

namespace credence::internal {
namespace {

using testing::HasSubstr;

FunctionModel moving_model() {
  FunctionModel model;
  const Matrix F = (Matrix(2, 2) << 1.0, 0.1, -0.2, 0.9).finished();
  const Matrix H = (Matrix(1, 2) << 1.0, 0.5).finished();
  model.f = [F](const Vector& x) { return Vector(F * x); };
  model.h = [H](const Vector& x) { return Vector(H * x); };
  model.F = [F](const Vector&) { return F; };
  model.H = [H](const Vector&) { return H; };
  model.Q = (Matrix(2, 2) << 0.0, 0.0, 0.0, 0.04).finished();  // singular
  model.R = Matrix::Constant(1, 1, 0.09);
  model.mean = Vector::Zero(2);
  model.P0 = (Matrix(2, 2) << 1.0, 0.0, 0.0, 0.0).finished();  // singular, too
  model.states = {"place", "speed"};
  return model;
}

TEST(FunctionBound, OfALinearModelIsTheKalmanFilter) {
  const FunctionModel model = moving_model();
  const PosteriorBound bound = posterior_bound(model, {.steps = 30}, 1.0, 3);
  ASSERT_EQ(bound.reason, "");
  ASSERT_EQ(bound.blocks.size(), 2U);
  FunctionEkf filter(model);
  filter.reset(model.mean, model.P0);
  for (std::size_t k = 0; k < 30; ++k) {
    filter.predict();
    filter.update(Vector::Zero(1));
    for (std::size_t i = 0; i < 2; ++i) {
      const double variance = filter.covariance().diagonal()[static_cast<Index>(i)];
      EXPECT_NEAR(bound.blocks[i].bound[k], variance, 1e-12) << k;
      EXPECT_NEAR(bound.blocks[i].at_truth[k], variance, 1e-12) << k;
    }
  }
}

// The recursion is the last block of the inverse of the mean information of the whole trajectory, which is
// assembled here from all states at once.
TEST(FunctionBound, IsThatOfTheWholeTrajectory) {
  FunctionModel model;
  model.f = [](const Vector& x) { return Vector(Eigen::Vector2d(x[0] + 0.1 * x[1], x[1] - std::sin(x[0]))); };
  model.F = [](const Vector& x) {
    return Matrix((Matrix(2, 2) << 1.0, 0.1, -std::cos(x[0]), 1.0).finished());
  };
  model.h = [](const Vector& x) { return Vector::Constant(1, x[0] * x[0]).eval(); };
  model.H = [](const Vector& x) { return Matrix((Matrix(1, 2) << 2.0 * x[0], 0.0).finished()); };
  model.Q = (Matrix(2, 2) << 0.02, 0.005, 0.005, 0.03).finished();
  model.R = Matrix::Constant(1, 1, 0.25);
  model.mean = Eigen::Vector2d(0.7, -0.2);
  model.P0 = (Matrix(2, 2) << 0.2, 0.03, 0.03, 0.1).finished();
  model.states = {"angle", "rate"};
  constexpr std::int64_t kRuns = 5, kSteps = 7;
  const PlugSettings settings{.steps = kSteps};
  const PosteriorBound bound = posterior_bound(model, settings, 1.0, kRuns);
  const FunctionWorld world(model);
  const Matrix Q_inverse = model.Q.inverse();
  Matrix J = Matrix::Zero(2 * (kSteps + 1), 2 * (kSteps + 1));
  J.topLeftCorner(2, 2) = model.P0.inverse();
  for (std::int64_t run = 0; run < kRuns; ++run) {
    const NoiseSource source = settings.source();
    NoiseDraw initial(source, run, 0, NoisePurpose::initial);
    Vector x = world.initial(initial);
    for (std::int64_t k = 1; k <= kSteps; ++k) {
      Matrix D(2, 4);  // of the residual x⁺ − f(x) by both
      D << -model.F(x), Matrix::Identity(2, 2);
      J.block(2 * k - 2, 2 * k - 2, 4, 4) += D.transpose() * Q_inverse * D / static_cast<double>(kRuns);
      NoiseDraw process(source, run, k, NoisePurpose::process);
      x = world.step(x, k, process);
      const Matrix H = model.H(x);
      J.block(2 * k, 2 * k, 2, 2) += H.transpose() * H / (model.R(0, 0) * static_cast<double>(kRuns));
    }
  }
  // The bound of step k knows nothing of later ones.
  const Matrix whole = J.inverse();
  for (Index i = 0; i < 2; ++i) {
    const double last = whole(2 * kSteps + i, 2 * kSteps + i);
    EXPECT_NEAR(bound.blocks[static_cast<std::size_t>(i)].bound.back(), last, 1e-11 * last);
  }
}

/// A number that stands still and is measured, from a variance of 1.
FunctionModel standing_number() {
  FunctionModel model;
  model.f = model.h = [](const Vector& x) { return x; };
  model.F = model.H = [](const Vector& x) { return Matrix::Identity(x.size(), x.size()).eval(); };
  model.Q = Matrix::Zero(1, 1);
  model.R = model.P0 = Matrix::Identity(1, 1);
  model.mean = Vector::Zero(1);
  return model;
}

// J of the bound grows by the share s of truths that were seen, so that J = 1 + Σ s; what a filter claims is
// a mean over truths of 1 / (1 + n), n of them seen so far.
TEST(FunctionBound, OfStepsThatAreMissedIsTheMeanInformation) {
  constexpr std::int64_t kRuns = 40, kSteps = 12;
  const double detection = 0.4;
  const PlugSettings settings{.steps = kSteps};
  const PosteriorBound bound = posterior_bound(standing_number(), settings, detection, kRuns);
  ASSERT_EQ(bound.blocks.size(), 1U);
  EXPECT_EQ(bound.runs, kRuns);
  const NoiseSource source = settings.source();
  std::vector<int> seen(kRuns, 0);
  for (std::int64_t k = 1; k <= kSteps; ++k) {
    double information = 1.0, claimed = 0.0;
    for (std::int64_t run = 0; run < kRuns; ++run) {
      int& of_run = seen[static_cast<std::size_t>(run)];
      of_run += source.uniform(run, k, NoisePurpose::detection, 0) < detection ? 1 : 0;
      information += of_run / static_cast<double>(kRuns);
      claimed += 1.0 / (1.0 + of_run) / static_cast<double>(kRuns);
    }
    EXPECT_NEAR(bound.blocks[0].bound[static_cast<std::size_t>(k - 1)], 1.0 / information, 1e-13) << k;
    EXPECT_NEAR(bound.blocks[0].at_truth[static_cast<std::size_t>(k - 1)], claimed, 1e-13) << k;
  }
  EXPECT_GT(bound.blocks[0].at_truth.back(), bound.blocks[0].bound.back());
}

TEST(FunctionBound, JacobiansByDifferencesGiveTheSame) {
  FunctionModel given = moving_model();
  given.Q(0, 0) = 0.01;
  given.states = {"angle:angle", "rate"};
  given.h = [](const Vector& x) { return Vector::Constant(1, std::sin(x[0])).eval(); };
  given.H = [](const Vector& x) { return Matrix((Matrix(1, 2) << std::cos(x[0]), 0.0).finished()); };
  FunctionModel without = given;
  without.F = without.H = nullptr;
  const PosteriorBound a = posterior_bound(given, {.steps = 10}, 1.0, 8),
                       b = posterior_bound(without, {.steps = 10}, 1.0, 8);
  ASSERT_EQ(a.blocks.size(), 2U);
  ASSERT_EQ(b.blocks.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(a.blocks[i].mean_bound(), b.blocks[i].mean_bound(), 1e-8 * a.blocks[i].mean_bound());
    EXPECT_NEAR(a.blocks[i].mean_at_truth(), b.blocks[i].mean_at_truth(), 1e-8 * a.blocks[i].mean_at_truth());
  }
}

// Differences of a linear f are constant but for rounding, ε |f| over their step: 4e-11 of states of size 1,
// and 4e-5 where another state is 1e6. Q and P0 are singular.
TEST(FunctionBound, OfALinearMotionWithoutItsJacobianIsTheSameWhereQIsSingular) {
  for (const auto& [size, tolerance] : {std::pair{1.0, 1e-8}, std::pair{1e6, 1e-2}}) {
    FunctionModel given = moving_model();
    given.mean = Eigen::Vector2d(size, 0.3);
    given.P0(0, 0) = size * size;
    FunctionModel without = given;
    without.F = nullptr;
    const PosteriorBound a = posterior_bound(given, {.steps = 30}, 1.0, 8),
                         b = posterior_bound(without, {.steps = 30}, 1.0, 8);
    ASSERT_EQ(b.reason, "") << size;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(a.blocks[i].mean_bound(), b.blocks[i].mean_bound(), tolerance * a.blocks[i].mean_bound());
    }
  }
}

TEST(FunctionBound, ThatIsNotThereHasAReason) {
  FunctionModel bent = moving_model();
  bent.F = [F = bent.F](const Vector& x) {
    return Matrix(F(x) + 0.1 * std::sin(x[0]) * Matrix::Identity(2, 2));
  };
  EXPECT_THAT(posterior_bound(bent, {.steps = 3}, 1.0, 4).reason, HasSubstr("process noise is singular"));
  FunctionModel hardly = moving_model();  // its Jacobian differs by some 1e-5 between the truths
  hardly.f = [f = hardly.f](const Vector& x) {
    return Vector(f(x) + 1e-5 * Vector(Eigen::Vector2d(std::sin(x[0]), 0.0)));
  };
  hardly.F = nullptr;
  EXPECT_THAT(posterior_bound(hardly, {.steps = 3}, 1.0, 4).reason, HasSubstr("Jacobian of the motion"));
  FunctionModel exact = standing_number();
  exact.R.setZero();
  EXPECT_EQ(posterior_bound(exact, {.steps = 3}, 1.0, 4).reason, kBoundOfNoisyMeasurements);
}

}  // namespace
}  // namespace credence::internal
