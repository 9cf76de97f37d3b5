#include "montecarlo/worlds/plugged/model_plug.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "core/nan.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

/// Three states of which two sums are measured, nothing of it diagonal.
FunctionModel coupled_model() {
  const Matrix F = (Matrix(3, 3) << 1.0, 0.2, 0.0, -0.1, 0.9, 0.3, 0.0, 0.05, 1.1).finished();
  const Matrix H = (Matrix(2, 3) << 1.0, -0.5, 0.0, 0.3, 0.0, 2.0).finished();
  FunctionModel model;
  model.f = [F](const Vector& x) { return Vector(F * x); };
  model.h = [H](const Vector& x) { return Vector(H * x); };
  model.F = [F](const Vector&) { return F; };
  model.H = [H](const Vector&) { return H; };
  model.Q = (Matrix(3, 3) << 0.2, 0.05, 0.0, 0.05, 0.1, -0.02, 0.0, -0.02, 0.3).finished();
  model.R = (Matrix(2, 2) << 0.5, 0.1, 0.1, 0.2).finished();
  model.mean = Eigen::Vector3d(1.0, -2.0, 0.5);
  model.P0 = (Matrix(3, 3) << 1.0, 0.3, 0.1, 0.3, 2.0, -0.4, 0.1, -0.4, 0.7).finished();
  return model;
}

/// A heading that turns by two radians a step.
FunctionModel turning_heading() {
  FunctionModel model;
  model.f = [](const Vector& x) { return Vector(x.array() + 2.0); };
  model.h = [](const Vector& x) { return x; };
  model.Q = model.R = model.P0 = Matrix::Constant(1, 1, 0.01);
  model.mean = Vector::Zero(1);
  model.states = {"heading:angle"};
  model.measured_angles = {true};
  return model;
}

std::string said_of(const FunctionModel& model) {
  try {
    const FunctionWorld world(model);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(FunctionModel, NamesWhatDoesNotFit) {
  struct Case {
    void (*spoil)(FunctionModel&);
    std::string said;
  };
  const std::vector<Case> cases = {
      {[](FunctionModel&) {}, "accepted"},
      {[](FunctionModel& m) { m.f = nullptr; }, "f is missing"},
      {[](FunctionModel& m) { m.h = nullptr; }, "h is missing"},
      {[](FunctionModel& m) { m.mean.resize(0); }, "mean is empty"},
      {[](FunctionModel& m) { m.R.resize(0, 0); }, "R is empty"},
      {[](FunctionModel& m) { m.Q = Matrix::Identity(2, 2); }, "Q is 2x2: expected 3x3"},
      {[](FunctionModel& m) { m.P0 = Matrix::Identity(3, 4); }, "P0 is 3x4: expected 3x3"},
      {[](FunctionModel& m) { m.R = Matrix::Identity(2, 3); }, "R is 2x3: expected 2x2"},
      {[](FunctionModel& m) { m.Q(1, 1) = kNaN; }, "Q is not finite"},
      {[](FunctionModel& m) { m.R(0, 1) += 0.1; }, "R is not symmetric"},
      {[](FunctionModel& m) { m.Q(1, 1) = -m.Q(1, 1); }, "Q is not positive semidefinite"},
      {[](FunctionModel& m) { m.R = -m.R; }, "R is not positive semidefinite"},
      {[](FunctionModel& m) { m.P0 = -m.P0; }, "P0 is not positive semidefinite"},
      {[](FunctionModel& m) { m.f = m.h; }, "f(mean) has 2 entries: expected 3"},
      {[](FunctionModel& m) { m.h = m.f; }, "h(mean) has 3 entries: expected 2"},
      {[](FunctionModel& m) {
         m.states = {"a", "b"};
       },
       "states has 2 entries: expected 3"},
      {[](FunctionModel& m) {
         m.units = {"m", "rad"};
       },
       "units has 2 entries: expected 3"},
      {[](FunctionModel& m) {
         m.measured_angles = {true, false, true};
       },
       "measured_angles has 3 entries: expected 2"},
  };
  for (const Case& c : cases) {
    FunctionModel model = coupled_model();
    c.spoil(model);
    EXPECT_EQ(said_of(model), c.said);
    if (c.said != "accepted") {
      EXPECT_THROW(FunctionEkf{model}, std::invalid_argument) << c.said;
    }
  }
}

TEST(FunctionModel, StatesWithoutNamesAreNumbered) {
  FunctionModel model = coupled_model();
  EXPECT_EQ(FunctionWorld(model).layout().states, (std::vector<std::string>{"x1", "x2", "x3"}));
  model.states = {"pose.x", "pose.heading:angle", "speed"};
  model.measured_angles = {false, true};
  EXPECT_TRUE(FunctionWorld(model).layout().units.empty());
  model.units = {"m", "rad", "m/s"};
  const RunLayout layout = FunctionWorld(model).layout();
  EXPECT_EQ(layout.units, (std::vector<std::string>{"m", "rad", "m/s"}));
  EXPECT_EQ(layout.angles, (std::vector<bool>{false, true, false}));
  EXPECT_EQ(layout.sensors.front().angles, (std::vector<bool>{false, true}));
  EXPECT_EQ(layout.sensors.front().dim, 2);
  EXPECT_TRUE(layout.nonlinear);
}

// Of N draws with covariance C each entry of L⁻¹ (Σ e eᵀ / N) L⁻ᵀ, C = L Lᵀ, is 1 or 0 within 5 √(2/N).
TEST(FunctionWorld, NoiseHasTheCovariancesOfTheModel) {
  const FunctionModel model = coupled_model();
  const FunctionWorld world(model);
  const NoiseSource source(7, 0);
  constexpr int kDraws = 4000;
  Matrix P0 = Matrix::Zero(3, 3), Q = P0, R = Matrix::Zero(2, 2);
  const Vector x = Eigen::Vector3d(0.4, 0.1, -3.0);
  for (std::int64_t run = 0; run < kDraws; ++run) {
    NoiseDraw initial(source, run, 0, NoisePurpose::initial), process(source, run, 1, NoisePurpose::process),
        measurement(source, run, 1, NoisePurpose::measurement);
    const Vector e = world.initial(initial) - model.mean, w = world.step(x, 1, process) - model.f(x),
                 v = world.measure(x, 1, measurement) - model.h(x);
    P0 += e * e.transpose() / kDraws;
    Q += w * w.transpose() / kDraws;
    R += v * v.transpose() / kDraws;
  }
  const double bound = 5.0 * std::sqrt(2.0 / kDraws);
  for (const auto& [seen, exact] : {std::pair(P0, model.P0), std::pair(Q, model.Q), std::pair(R, model.R)}) {
    const Matrix L = Eigen::LLT<Matrix>(exact).matrixL();
    const Matrix whitened = L.inverse() * seen * L.inverse().transpose();
    EXPECT_LT((whitened - Matrix::Identity(L.rows(), L.cols())).cwiseAbs().maxCoeff(), bound) << exact;
  }
}

TEST(FunctionWorld, SingularCovariancesAreLegal) {
  FunctionModel model = coupled_model();
  model.P0.setZero();
  model.Q = Eigen::Vector3d(0.0, 1.0, 0.0).asDiagonal();
  const FunctionWorld world(model);
  const NoiseSource source(7, 0);
  NoiseDraw initial(source, 0, 0, NoisePurpose::initial), process(source, 0, 1, NoisePurpose::process);
  EXPECT_EQ(world.initial(initial), model.mean);
  const Vector w = world.step(model.mean, 1, process) - model.f(model.mean);
  EXPECT_EQ(w[0], 0.0);
  EXPECT_NE(w[1], 0.0);
  EXPECT_EQ(w[2], 0.0);
}

TEST(FunctionWorld, AnglesAreWrapped) {
  const FunctionWorld world(turning_heading());
  const NoiseSource source(7, 0);
  const double turn = 2.0 * std::numbers::pi;
  for (const double angle : {3.0 * turn + 0.5, -2.0 * turn - 1.0, 0.25}) {
    NoiseDraw one(source, 3, 1, NoisePurpose::measurement), same(source, 3, 1, NoisePurpose::measurement);
    const double z = world.measure(Vector::Constant(1, angle), 1, one)[0];
    EXPECT_NEAR(z, std::remainder(angle, turn) + 0.1 * same.normal(), 1e-13);
    EXPECT_NEAR(world.minus(Vector::Constant(1, angle), Vector::Constant(1, 0.1))[0],
                std::remainder(angle - 0.1, turn), 1e-13);
  }
}

// The other way to the same numbers: P = (P⁻⁻¹ + Hᵀ R⁻¹ H)⁻¹ and x̂ = P (P⁻⁻¹ x̂⁻ + Hᵀ R⁻¹ z).
TEST(FunctionEkf, OfALinearModelIsTheInformationFilter) {
  const FunctionModel model = coupled_model();
  FunctionEkf filter(model);
  filter.reset(model.mean, model.P0);
  Vector x = model.mean;
  Matrix P = model.P0;
  const Matrix F = model.F(x), H = model.H(x), told = H.transpose() * model.R.inverse();
  for (int k = 1; k <= 10; ++k) {
    const Vector z = Eigen::Vector2d(0.3 * k, std::cos(k));
    x = (F * x).eval();
    P = (F * P * F.transpose() + model.Q).eval();
    const Vector nu = z - H * x;
    const Matrix S = H * P * H.transpose() + model.R, before = P.inverse();
    P = (before + told * H).inverse();
    x = (P * (before * x + told * z)).eval();
    filter.predict();
    ASSERT_TRUE(filter.update(z));
    EXPECT_LT((filter.innovation() - nu).norm(), 1e-11) << k;
    EXPECT_LT((filter.innovation_covariance() - S).norm(), 1e-11) << k;
    EXPECT_LT((filter.state() - x).norm(), 1e-11) << k;
    EXPECT_LT((filter.covariance() - P).norm(), 1e-11) << k;
    EXPECT_EQ(filter.covariance(), Matrix(filter.covariance().transpose())) << k;
  }
}

TEST(FunctionEkf, JacobiansByDifferencesAreAsGood) {
  FunctionModel given = coupled_model();
  given.f = [](const Vector& x) {
    return Vector(Eigen::Vector3d(x[0] + 0.1 * std::sin(x[1]), x[1] + 0.1 * x[0] * x[2], 0.9 * x[2]));
  };
  given.F = [](const Vector& x) {
    Matrix F(3, 3);
    F << 1.0, 0.1 * std::cos(x[1]), 0.0, 0.1 * x[2], 1.0, 0.1 * x[0], 0.0, 0.0, 0.9;
    return F;
  };
  FunctionModel without = given;
  without.F = without.H = nullptr;
  FunctionEkf a(given), b(without);
  for (FunctionEkf* filter : {&a, &b}) {
    filter->reset(given.mean, given.P0);
    EXPECT_EQ(filter->jacobian_problem(), std::nullopt);
    for (int k = 0; k < 5; ++k) {
      filter->predict();
      ASSERT_TRUE(filter->update(Eigen::Vector2d(1.0, -0.5)));
    }
  }
  EXPECT_LT((a.state() - b.state()).norm(), 1e-8);
  EXPECT_LT((a.covariance() - b.covariance()).norm(), 1e-8);
}

// A measurement just beyond half a turn moves a heading just short of it forth, not back by a turn.
TEST(FunctionEkf, InnovationsAndStatesOfAnglesAreWrapped) {
  FunctionEkf filter(turning_heading());
  filter.reset(Vector::Constant(1, std::numbers::pi - 0.1), Matrix::Constant(1, 1, 0.03));
  ASSERT_TRUE(filter.update(Vector::Constant(1, -std::numbers::pi + 0.1)));
  EXPECT_NEAR(filter.innovation()[0], 0.2, 1e-14);
  EXPECT_NEAR(filter.state()[0], -std::numbers::pi + 0.05, 1e-14);  // K = 0.03 / 0.04
}

TEST(FunctionEkf, AnSThatIsNotPositiveDefiniteIsToldAndChangesNothing) {
  FunctionModel model = coupled_model();
  model.R.setZero();
  FunctionEkf filter(model);
  const Vector known = Eigen::Vector3d(0.1, 0.2, 0.3);
  filter.reset(known, Matrix::Zero(3, 3));
  EXPECT_FALSE(filter.update(Vector::Zero(2)));
  EXPECT_EQ(filter.state(), known);
  EXPECT_TRUE(filter.covariance().isZero(0.0));
}

std::string jacobian_problem_of(const FunctionModel& model) {
  FunctionEkf filter(model);
  filter.reset(model.mean, model.P0);
  return filter.jacobian_problem().value_or("none");
}

TEST(FunctionEkf, NamesTheEntryOfAWrongJacobian) {
  FunctionModel model = coupled_model();
  EXPECT_EQ(jacobian_problem_of(model), "none");
  model.F = [F = model.F](const Vector& x) {
    Matrix wrong = F(x);
    wrong(1, 1) += 0.5;
    wrong(2, 0) += 1e-7;  // no more than differences err
    return wrong;
  };
  EXPECT_THAT(jacobian_problem_of(model),
              HasSubstr("F is not the Jacobian of its function: entry (1, 1) is 1.4, by differences"));
  model = coupled_model();
  model.H = [](const Vector&) { return Matrix::Identity(3, 3).eval(); };
  EXPECT_THAT([&] { jacobian_problem_of(model); },
              ::testing::ThrowsMessage<std::invalid_argument>("H(mean) is 3x3: expected 2x3"));
  model.H = [H = coupled_model().H, mean = model.mean](const Vector& x) {
    return x == mean ? H(x) : Matrix::Identity(3, 3).eval();
  };
  FunctionEkf elsewhere(model);
  elsewhere.reset(2.0 * model.mean, model.P0);
  EXPECT_EQ(elsewhere.jacobian_problem(), "H is 3x3: expected 2x3");
}

// Not a number is no derivative, wherever it stands.
TEST(FunctionEkf, AnEntryThatIsNotANumberIsAProblemOfItsJacobian) {
  for (Index row = 0; row < 3; ++row) {
    for (Index col = 0; col < 3; ++col) {
      FunctionModel model = coupled_model();
      model.F = [F = model.F, row, col](const Vector& x) {
        Matrix wrong = F(x);
        wrong(row, col) = std::nan("");
        return wrong;
      };
      const std::string entry = "entry (" + std::to_string(row) + ", " + std::to_string(col) + ") is nan";
      EXPECT_THAT(jacobian_problem_of(model), HasSubstr(entry));
    }
  }
}

TEST(DifferenceJacobian, IsTheDerivative) {
  const auto polar = [](const Vector& x) {
    return Vector(Eigen::Vector2d(x.norm(), std::atan2(x[1], x[0])));
  };
  for (const double angle : {0.3, std::numbers::pi, -2.0}) {
    const Vector x = 3.0 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    Matrix J(2, 2);
    J << x[0] / 3.0, x[1] / 3.0, -x[1] / 9.0, x[0] / 9.0;
    EXPECT_LT((difference_jacobian(polar, x, {false, true}) - J).norm(), 1e-9) << angle;
  }
}

// The steps grow with the state: a step of fixed length would lose all digits at 1e9.
TEST(DifferenceJacobian, HasItsDigitsAtEveryScale) {
  const auto cube = [](const Vector& x) { return Vector(x.array().cube()); };
  for (const double at : {0.0, 1e-8, 2.0, 1e9}) {
    const double J = difference_jacobian(cube, Vector::Constant(1, at))(0, 0);
    EXPECT_NEAR(J, 3.0 * at * at, 1e-9 * std::max(1.0, 3.0 * at * at)) << at;
  }
  const auto twice = [](const Vector& x) { return Vector(x.replicate(2, 1)); };
  const Matrix J = difference_jacobian(twice, Eigen::Vector2d(1.0, 2.0));
  ASSERT_EQ(J.rows(), 4);
  ASSERT_EQ(J.cols(), 2);
  EXPECT_LT((J - Matrix::Identity(2, 2).replicate(2, 1)).norm(), 1e-9);
}

}  // namespace
}  // namespace credence::internal
