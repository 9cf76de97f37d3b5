#include "montecarlo/worlds/plugged/function_ukf.h"

#include <gtest/gtest.h>

#include "montecarlo/worlds/plugged/plugged_experiment.h"

namespace credence::internal {
namespace {

FunctionModel linear_with_input_noise() {
  FunctionModel model;
  const Matrix F = (Matrix(2, 2) << 1.0, 0.5, -0.1, 0.9).finished();
  const Matrix H = (Matrix(1, 2) << 1.0, 0.3).finished();
  model.f = [F](const Vector& x) { return Vector(F * x); };
  model.h = [H](const Vector& x) { return Vector(H * x); };
  model.F = [F](const Vector&) { return F; };
  model.H = [H](const Vector&) { return H; };
  model.Q = Matrix::Zero(2, 2);
  model.Q(1, 1) = 0.04;
  model.R = Matrix::Constant(1, 1, 0.25);
  model.mean = Eigen::Vector2d(0.0, 1.0);
  model.P0 = Eigen::Vector2d(1.0, 0.0).asDiagonal();
  return model;
}

// Of linear functions sigma points have the exact moments, of a singular P0 too.
TEST(FunctionUkf, IsTheKalmanFilterWhereAllIsLinear) {
  const FunctionModel model = linear_with_input_noise();
  for (const double spread : {1.0, 0.1}) {
    const PluggedExperiment ekf(FunctionWorld(model), [&] { return FunctionEkf(model); }, {.steps = 30});
    const PluggedExperiment ukf(FunctionWorld(model), [&] { return FunctionUkf(model, spread); },
                                {.steps = 30});
    const RunTrace a = ekf.trace(4), b = ukf.trace(4);
    for (std::size_t k = 0; k < a.steps.size(); ++k) {
      EXPECT_LT((a.steps[k].error - b.steps[k].error).norm(), 1e-10) << k;
      EXPECT_LT((a.steps[k].P - b.steps[k].P).norm(), 1e-10) << k;
    }
  }
}

// x² of N(m, p) has the mean m² + p and the variance 4 m² p + 2 p², and the covariance 2 m p with x: what
// three sigma points at √3 σ have exactly, and two at σ but for the term 2 p².
TEST(FunctionUkf, KnowsTheMomentsOfASquare) {
  FunctionModel model;
  model.f = [](const Vector& x) { return x; };
  model.h = [](const Vector& x) { return Vector(x.cwiseAbs2()); };
  model.Q = Matrix::Zero(1, 1);
  model.R = Matrix::Constant(1, 1, 0.5);
  model.mean = Vector::Constant(1, 3.0);
  model.P0 = Matrix::Constant(1, 1, 0.2);
  FunctionUkf filter(model);
  filter.reset(model.mean, model.P0);
  filter.predict();
  ASSERT_TRUE(filter.update(Vector::Constant(1, 10.0)));
  EXPECT_NEAR(filter.innovation()[0], 10.0 - (9.0 + 0.2), 1e-12);
  const double S = filter.innovation_covariance()(0, 0);
  EXPECT_NEAR(S, 4.0 * 9.0 * 0.2 + 2.0 * 0.2 * 0.2 + 0.5, 1e-12);
  EXPECT_NEAR(filter.state()[0], 3.0 + 2.0 * 3.0 * 0.2 / S * filter.innovation()[0], 1e-12);
}

}  // namespace
}  // namespace credence::internal
