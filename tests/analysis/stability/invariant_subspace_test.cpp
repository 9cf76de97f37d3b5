#include "analysis/stability/invariant_subspace.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>
#include <random>

#include "tests/analysis/stability/stability_problems.h"

namespace credence::internal {
namespace {

using Complex = std::complex<double>;
using CircleList = std::vector<UnitCircle>;
constexpr UnitCircle kWithinCircle = UnitCircle::inside, kOnCircle = UnitCircle::on,
                     kBeyondCircle = UnitCircle::outside;

/// The sine of the largest angle between a vector, or the columns, and the span of orthonormal columns.
double outside_of_span(const Matrix& columns, const Matrix& basis) {
  return (columns - basis * (basis.transpose() * columns)).norm() / columns.norm();
}

double not_orthonormal(const Matrix& basis) {
  return (basis.transpose() * basis - Matrix::Identity(basis.cols(), basis.cols())).norm();
}

TEST(UnitCircle, ToleranceDecidesSingleEigenvalues) {
  Eigen::VectorXcd values(7);
  values << 0.5, -1.0, Complex(0.6, 0.8), 1.0 + 0.9e-8, 1.0 + 1.1e-8, 1.0 - 3e-6, Complex(0.0, -2.0);
  EXPECT_EQ(classify_unit_circle(values.head(3)), (CircleList{kWithinCircle, kOnCircle, kOnCircle}));
  EXPECT_EQ(classify_unit_circle(values.segment(3, 1)), CircleList{kOnCircle});
  EXPECT_EQ(classify_unit_circle(values.segment(4, 1)), CircleList{kBeyondCircle});
  EXPECT_EQ(classify_unit_circle(values.segment(5, 2)), (CircleList{kWithinCircle, kBeyondCircle}));
  EXPECT_TRUE(classify_unit_circle(Eigen::VectorXcd(0)).empty());
}

TEST(UnitCircle, AScatteredChainIsJudgedByItsMean) {
  const auto scattered = [](Complex mean, double radius) {
    Eigen::VectorXcd values(4);
    for (int j = 0; j < 3; ++j) values[j] = mean + std::polar(radius, 2.0 * std::numbers::pi * j / 3.0 + 0.1);
    values[3] = 0.3;
    return values;
  };
  // Rounding scatters a chain of three by some ε^(1/3) = 6e-6; ten times that is let pass.
  EXPECT_EQ(classify_unit_circle(scattered(-1.0, 5e-5)),
            (CircleList{kOnCircle, kOnCircle, kOnCircle, kWithinCircle}));
  EXPECT_EQ(classify_unit_circle(scattered(Complex(0.6, 0.8), 5e-5)),
            (CircleList{kOnCircle, kOnCircle, kOnCircle, kWithinCircle}));
  const CircleList off = classify_unit_circle(scattered(1.0 + 1e-4, 5e-5));
  EXPECT_EQ(off, (CircleList{kBeyondCircle, kBeyondCircle, kBeyondCircle, kWithinCircle}));
  const CircleList far = classify_unit_circle(scattered(1.0, 1e-2));
  EXPECT_EQ(far, (CircleList{kBeyondCircle, kWithinCircle, kWithinCircle, kWithinCircle}));
}

TEST(InvariantSubspaces, OfATriangleByHand) {
  // [0.5 1; 0 2]: eigenvectors (1, 0) and (1, 1.5).
  const InvariantSubspaces modes(Matrix{{0.5, 1.0}, {0.0, 2.0}});
  ASSERT_TRUE(modes.ok());
  EXPECT_EQ(modes.count(kWithinCircle), 1);
  EXPECT_EQ(modes.count(kOnCircle), 0);
  EXPECT_EQ(modes.count(kBeyondCircle), 1);
  EXPECT_LT(outside_of_span(Vector{{1.0, 0.0}}, modes.basis(kWithinCircle)), 1e-15);
  EXPECT_LT(outside_of_span(Vector{{1.0, 1.5}}, modes.basis(kBeyondCircle)), 1e-15);
  EXPECT_EQ(modes.basis(kOnCircle).cols(), 0);
  EXPECT_EQ(modes.basis(kOnCircle).rows(), 2);
  EXPECT_EQ(modes.basis(kWithinCircle, kBeyondCircle).cols(), 2);
  EXPECT_TRUE(InvariantSubspaces(Matrix(0, 0)).ok());
}

TEST(InvariantSubspaces, AreThoseOfTheBlocksInAnyCoordinates) {
  // A turn on the circle, one inside, a Jordan block outside and an eigenvalue of 0, mixed up.
  Matrix J = Matrix::Zero(7, 7);
  J.block(0, 0, 2, 2) << 1.5, 1.0, 0.0, 1.5;
  J.block(2, 2, 2, 2) << 0.8, -0.6, 0.6, 0.8;
  J.block(5, 5, 2, 2) << 0.0, -0.5, 0.5, 0.0;
  std::mt19937_64 generator(5);
  const Matrix T = testing::random_matrix(7, 7, generator) + 3.0 * Matrix::Identity(7, 7);
  const InvariantSubspaces modes(Matrix(T * J * T.inverse()));
  ASSERT_TRUE(modes.ok());
  const std::pair<Matrix, Matrix> expected[] = {
      {modes.basis(kBeyondCircle), T.leftCols(2)},
      {modes.basis(kOnCircle), T.middleCols(2, 2)},
      {modes.basis(kWithinCircle), T.rightCols(3)},
      {modes.basis(kOnCircle, kBeyondCircle), T.leftCols(4)},
      {modes.basis(kWithinCircle, kOnCircle), T.rightCols(5)},
  };
  for (const auto& [basis, columns] : expected) {
    ASSERT_EQ(basis.cols(), columns.cols());
    EXPECT_LT(not_orthonormal(basis), 1e-13);
    EXPECT_LT(outside_of_span(columns, basis), 1e-11);
  }
}

TEST(PowerBoundedPart, LeavesOutTheEndsOfChains) {
  EXPECT_EQ(power_bounded_part(Matrix(0, 0)).size(), 0);
  EXPECT_EQ(power_bounded_part(Matrix::Identity(3, 3)).cols(), 3);
  const Matrix turn{{0.8, -0.6}, {0.6, 0.8}};
  EXPECT_EQ(power_bounded_part(turn).cols(), 2);
  // Chains of two at 1 and at a turn, and −1 alone: of each chain its first link stays bounded.
  Matrix J = Matrix::Zero(7, 7);
  J.block(0, 0, 2, 2) << 1.0, 1.0, 0.0, 1.0;
  J.block(2, 2, 2, 2) = J.block(4, 4, 2, 2) = turn;
  J.block(2, 4, 2, 2).setIdentity();
  J(6, 6) = -1.0;
  const Matrix basis = power_bounded_part(J);
  ASSERT_EQ(basis.cols(), 4);
  EXPECT_LT(not_orthonormal(basis), 1e-13);
  // The same chain in other coordinates, where rounding parts its eigenvalues.
  const Matrix T{{2.0, 1.0, 0.3}, {-1.0, 1.7, 0.2}, {0.4, 0.1, 1.3}};
  const Matrix chain{{1.0, 1.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, -1.0}};
  const Matrix part = power_bounded_part(Matrix(T * chain * T.inverse()));
  ASSERT_EQ(part.cols(), 2);
  EXPECT_LT(outside_of_span(T.col(0), part), 1e-7);
  EXPECT_LT(outside_of_span(T.col(2), part), 1e-7);
  for (const Index i : {0, 2, 3, 6}) EXPECT_LT(outside_of_span(Vector::Unit(7, i), basis), 1e-7) << i;
}

}  // namespace
}  // namespace credence::internal
