#include "analysis/tuning/innovation_sensitivities.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/analysis/tuning/local_level.h"

namespace credence::internal {
namespace {

using testing::local_level;
using testing::survey_model;

std::vector<NoiseDerivative> slopes(const LinearModel& model, const char* free, const Vector& phi) {
  return NoiseParameters(model, parse_free_noise(free)).derivatives(phi);
}

TEST(InnovationSensitivities, StepsAreThoseOfALocalLevelByHand) {
  // Prior 1 + q; s = p + r; K = p/s; next prior p r/s + q.
  const InnovationSensitivities filter(local_level(0.5, 2.0), {}, 3);
  ASSERT_TRUE(filter.ok());
  double p = 1.5;
  for (Index k = 0; k < 3; ++k) {
    const InnovationStep& step = filter.step(k);
    const double s = p + 2.0;
    EXPECT_NEAR(step.S_inverse(0, 0), 1.0 / s, 1e-15);
    EXPECT_NEAR(step.S_root_inverse(0, 0), 1.0 / std::sqrt(s), 1e-15);
    EXPECT_NEAR(step.log_determinant, std::log(s), 1e-15);
    EXPECT_NEAR(step.FK(0, 0), p / s, 1e-15);
    EXPECT_NEAR(step.closed(0, 0), 2.0 / s, 1e-15);
    p = p * 2.0 / s + 0.5;
  }
  EXPECT_EQ(filter.parameters(), 0);
}

TEST(InnovationSensitivities, DerivativesAreThoseOfDifferences) {
  const LinearModel model = survey_model();
  const NoiseParameters noise(model, parse_free_noise("full(Q),diag(R),P0"));
  const Vector phi = noise.start();
  const InnovationSensitivities filter(model, noise.derivatives(phi), 8);
  constexpr double h = 1e-5;
  for (Index i = 0; i < phi.size(); ++i) {
    const Vector shift = h * Vector::Unit(phi.size(), i);
    const InnovationSensitivities more(noise.at(phi + shift), {}, 8), less(noise.at(phi - shift), {}, 8);
    for (Index k = 0; k < 8; ++k) {
      const Matrix S_dot = (more.step(k).S_inverse.inverse() - less.step(k).S_inverse.inverse()) / (2.0 * h);
      const Matrix FK_dot = (more.step(k).FK - less.step(k).FK) / (2.0 * h);
      const InnovationStep& step = filter.step(k);
      EXPECT_LT((step.S_dot[static_cast<std::size_t>(i)] - S_dot).norm(), 1e-7) << i << ", " << k;
      EXPECT_LT((step.FK_dot.middleRows(2 * i, 2) - FK_dot).norm(), 1e-7) << i << ", " << k;
      const double trace = (more.step(k).log_determinant - less.step(k).log_determinant) / (2.0 * h);
      EXPECT_NEAR(step.trace[i], trace, 1e-7) << i << ", " << k;
    }
  }
}

TEST(InnovationSensitivities, InformationIsThatOfTheWholeRecord) {
  // ½ tr(Σ⁻¹ Σ̇_i Σ⁻¹ Σ̇_j) of z_1 … z_n, Σ_kl = p0 + min(k, l) q + r δ_kl.
  constexpr Index kLength = 120;  // of which most are settled
  constexpr double q = 0.3, r = 2.0;
  Matrix by_q(kLength, kLength);
  for (Index k = 0; k < kLength; ++k) {
    for (Index l = 0; l < kLength; ++l) by_q(k, l) = q * static_cast<double>(std::min(k, l) + 1);
  }
  const Matrix by_r = r * Matrix::Identity(kLength, kLength), by_start = Matrix::Ones(kLength, kLength);
  const Matrix inverse = (by_q + by_r + by_start).inverse();
  const Matrix* slopes_of_record[] = {&by_q, &by_r, &by_start};
  const InnovationSensitivities filter(local_level(q, r),
                                       slopes(local_level(q, r), "Q,R,P0", Vector::Zero(3)), kLength);
  const Matrix information = filter.expected_information(kLength);
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) {
      const double expected = 0.5 * (inverse * *slopes_of_record[i] * inverse * *slopes_of_record[j]).trace();
      EXPECT_NEAR(information(i, j), expected, 1e-9) << i << ", " << j;
    }
  }
}

TEST(InnovationSensitivities, AddOneInformationAStepOnceSettled) {
  const LinearModel model = local_level(0.5, 1.0);
  const InnovationSensitivities filter(model, slopes(model, "Q,R", Vector::Zero(2)), 100'000);
  const Matrix one = filter.expected_information(5001) - filter.expected_information(5000);
  const Matrix many = filter.expected_information(100'000) - filter.expected_information(5000);
  EXPECT_LT((many - 95'000.0 * one).norm(), 1e-6 * many.norm());
}

TEST(InnovationSensitivities, SayWhereSIsNotPositiveDefinite) {
  LinearModel model = local_level(0.0, 0.0);
  model.P0.setZero();
  EXPECT_FALSE(InnovationSensitivities(model, {}, 5).ok());
  model.R(0, 0) = std::nan("");
  EXPECT_FALSE(InnovationSensitivities(model, {}, 5).ok());
  EXPECT_TRUE(InnovationSensitivities(local_level(0.0, 1.0), {}, 5).ok());
}

TEST(InnovationSensitivities, SettleInEveryState) {
  // A local level beside a constant of variance 1e10 that nobody sees.
  LinearModel model = testing::local_level(1e-8, 1e-6);
  model.F = model.G = Matrix::Identity(2, 2);
  model.H = Matrix{{0.0, 1.0}};
  model.Q = Vector{{0.0, 1e-8}}.asDiagonal();
  model.P0 = Vector{{1e10, 1.0}}.asDiagonal();
  model.layout.vehicle = 2;
  const InnovationSensitivities both(model, {}, 50), alone(testing::local_level(1e-8, 1e-6), {}, 50);
  EXPECT_NEAR(both.step(49).log_determinant, alone.step(49).log_determinant, 1e-9);
}

}  // namespace
}  // namespace credence::internal
