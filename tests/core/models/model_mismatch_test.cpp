#include "core/models/model_mismatch.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

LinearModel model(double f, double h) {
  LinearModel m;
  m.F = (Matrix(2, 2) << f, 0.5, -0.25, 0.75).finished();
  m.G = (Matrix(2, 1) << 1, 2).finished();
  m.H = (Matrix(1, 2) << h, 1).finished();
  m.Q = m.R = Matrix::Ones(1, 1);
  m.P0 = (Matrix(2, 2) << 2, 1, 1, 2).finished();
  m.layout = {.vehicle = 2, .landmark = 0, .landmarks = 0};
  return m;
}

LinearModel error_model(const LinearModel& truth, const LinearModel& assumed) {
  return error_models({&truth, 1}, {&assumed, 1}).front();
}

TEST(ModelMismatch, AFilterThatKnowsTheDynamicsHasTheTruthsErrors) {
  const LinearModel truth = model(1.0, 1.0);
  LinearModel assumed = truth;
  assumed.Q *= 3.0;
  EXPECT_TRUE(knows_dynamics(truth, assumed));
  EXPECT_EQ(error_model(truth, assumed).F, truth.F);
}

// State and estimate side by side; the numbers are exact in binary.
TEST(ModelMismatch, ErrorAndStateAreThoseOfTruthAndFilter) {
  const LinearModel truth = model(1.0, 1.0), assumed = model(0.5, 2.0);
  EXPECT_FALSE(knows_dynamics(truth, assumed));
  const LinearModel joint = error_model(truth, assumed);
  const Matrix gain = (Matrix(2, 1) << 0.5, -0.25).finished(), K = padded(gain, 4, 1);
  Vector x = (Vector(2) << 1, -2).finished(), estimate = Vector::Zero(2), a(4);
  a << x - estimate, x;
  for (int k = 1; k < 6; ++k) {
    const Vector v = Vector::Constant(1, 0.5 * k), w = Vector::Constant(1, -0.25 * k);
    x = truth.F * x + truth.G * v;
    estimate = assumed.F * estimate;
    const Vector nu = truth.H * x + w - assumed.H * estimate;
    estimate += gain * nu;
    a = joint.F * a + joint.G * v;
    const Vector nu_of_joint = joint.H * a + w;
    a -= K * nu_of_joint;
    EXPECT_EQ(nu_of_joint, nu) << k;
    EXPECT_EQ(Vector(a.head(2)), Vector(x - estimate)) << k;
    EXPECT_EQ(Vector(a.tail(2)), x) << k;
  }
  EXPECT_EQ(joint.P0, Matrix(truth.P0.replicate(2, 2)));
}

}  // namespace
}  // namespace credence::internal
