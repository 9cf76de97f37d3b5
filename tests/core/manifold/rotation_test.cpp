#include "core/manifold/rotation.h"

#include <gtest/gtest.h>

#include <numbers>

namespace credence::internal {
namespace {

constexpr double kAngles[] = {-3.0, -0.7, -1e-3, -2e-9, 0.0, 1e-12, 1e-5, 0.9999e-4, 1.0001e-4, 0.4, 3.1};

TEST(Rotation, QuarterTurnIsItsDerivativeAtZero) {
  const Eigen::Vector2d v(0.3, -2.0);
  EXPECT_LT((quarter_turn(v) - rotation(0.5 * std::numbers::pi) * v).norm(), 1e-15);
  EXPECT_LT((quarter_turn(v) - (rotation(1e-6) * v - rotation(-1e-6) * v) / 2e-6).norm(), 1e-9);
}

// V(φ) = ∫₀¹ R(tφ) dt by Simpson's rule; J V φ = R − I.
TEST(Rotation, ExponentialFactorIsTheIntegral) {
  for (const double angle : kAngles) {
    Eigen::Matrix2d integral = rotation(0.0) + rotation(angle);
    constexpr int kPieces = 200;
    for (int i = 1; i < kPieces; ++i) integral += (i % 2 == 1 ? 4.0 : 2.0) * rotation(angle * i / kPieces);
    integral /= 3.0 * kPieces;
    EXPECT_LT((exponential_factor(angle) - integral).norm(), 1e-9) << angle;
  }
}

TEST(Rotation, LogarithmFactorIsItsInverse) {
  for (const double angle : kAngles) {
    const Eigen::Matrix2d product = logarithm_factor(angle) * exponential_factor(angle);
    EXPECT_LT((product - Eigen::Matrix2d::Identity()).norm(), 1e-14) << angle;
  }
}

}  // namespace
}  // namespace credence::internal
