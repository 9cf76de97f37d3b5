#include "analysis/evidence/verdicts/map_consistency.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <stdexcept>

namespace credence::internal {
namespace {

/// A map of ten points with a random joint covariance, and an error drawn from it.
struct MapCase {
  Vector truth, error;
  Matrix P;
};

MapCase map_case(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  constexpr Index n = 20;
  MapCase c{Vector(n), Vector(n), Matrix(n, n)};
  Matrix A(n, n);
  Vector w(n);
  for (Index i = 0; i < n; ++i) {
    c.truth(i) = 10 * normal(random);
    w(i) = normal(random);
    for (Index j = 0; j < n; ++j) A(i, j) = 1e-3 * normal(random);
  }
  c.P = A * A.transpose() + 1e-6 * Matrix::Identity(n, n);
  c.error = Eigen::LLT<Matrix>(c.P).matrixL() * w;
  return c;
}

// E = dof, Var = 2 dof for a sum of independent χ².
TEST(MapConsistency, IsChiSquareForAnErrorFromItsCovariance) {
  double placed = 0, shape = 0;
  constexpr int kMaps = 200;
  for (unsigned seed = 0; seed < kMaps; ++seed) {
    const MapCase c = map_case(seed);
    const MapConsistency result = judge_map(c.truth + c.error, c.truth, c.truth, c.P);
    ASSERT_TRUE(result.placed.ok && result.shape.ok);
    EXPECT_EQ(result.placed.dof, 20);
    EXPECT_EQ(result.shape.dof, 17);
    placed += result.placed.value;
    shape += result.shape.value;
  }
  EXPECT_NEAR(placed, 20 * kMaps, 5 * std::sqrt(2.0 * 20 * kMaps));
  EXPECT_NEAR(shape, 17 * kMaps, 5 * std::sqrt(2.0 * 17 * kMaps));
}

TEST(MapConsistency, TheShapeDoesNotDependOnWhereTheMapLies) {
  const MapCase c = map_case(1);
  const MapConsistency here = judge_map(c.truth + c.error, c.truth, c.truth, c.P);
  // The same map turned by 40° and moved, with its covariance turned as well.
  const Eigen::Rotation2Dd turn(0.7);
  const Vector shift = Eigen::Vector2d(3, -5).replicate(10, 1);
  Matrix T = Matrix::Zero(20, 20);
  for (Index i = 0; i < 20; i += 2) T.block<2, 2>(i, i) = turn.toRotationMatrix();
  const MapConsistency there =
      judge_map(T * (c.truth + c.error) + shift, c.truth, T * c.truth + shift, T * c.P * T.transpose());
  EXPECT_NEAR(there.shape.value, here.shape.value, 1e-6 * here.shape.value);
  EXPECT_GT(there.placed.value, 1e3 * here.placed.value);
  EXPECT_LT(there.placed_p_value, 1e-6);
}

TEST(MapConsistency, OfTooFewPointsHasNoShape) {
  const Vector four = Vector::Ones(4);
  const MapConsistency two = judge_map(four, four, four, Matrix::Identity(4, 4));
  EXPECT_TRUE(two.placed.ok);
  EXPECT_FALSE(two.shape.ok);
  EXPECT_TRUE(std::isnan(two.shape_p_value));
  EXPECT_FALSE(judge_map(Vector(), Vector(), Vector(), Matrix()).placed.ok);
  EXPECT_THROW(judge_map(four, four, Vector::Ones(6), Matrix::Identity(4, 4)), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
