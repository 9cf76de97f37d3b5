#include "core/filters/block_map_state.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace credence::internal {
namespace {

using PlanarMap = BlockMapState<3, 2>;
using LineMap = BlockMapState<1, 1>;

// A covariance whose landmarks are uncorrelated with each other: diagonally dominant, with seeded
// correlations of the vehicle.
Matrix star_covariance(const BlockLayout& layout, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> small(-0.2, 0.2);
  const Index n = layout.state_dim(), r = layout.vehicle;
  Matrix P = Matrix::Identity(n, n);
  P.topLeftCorner(r, r).diagonal().setConstant(3.0);
  for (Index j = r; j < n; ++j) {
    for (Index i = 0; i < r; ++i) P(i, j) = P(j, i) = small(random);
  }
  for (Index l = 0; l < layout.landmarks && layout.landmark == 2; ++l) {
    const Index at = layout.landmark_offset(l);
    P(at, at + 1) = P(at + 1, at) = small(random);
  }
  return P;
}

double least_eigenvalue_of(const Matrix& P) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(P, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
}

// The Kalman filter of a dense state, for scalars linearised at the prior.
struct DenseUpdate {
  Vector x;
  Matrix P, gain;

  void correct(const std::vector<Vector>& rows, const std::vector<double>& nu, double r) {
    Matrix H(std::ssize(rows), x.size());
    for (Index i = 0; i < H.rows(); ++i) H.row(i) = rows[static_cast<std::size_t>(i)];
    const Matrix S = H * P * H.transpose() + r * Matrix::Identity(H.rows(), H.rows());
    gain = S.ldlt().solve(H * P).transpose();
    x += gain * Eigen::Map<const Vector>(nu.data(), std::ssize(nu));
    P -= (gain * H * P).eval();
  }
};

// What a landmark that is looked at shares with the vehicle stands apart from P until P is asked for.
TEST(BlockMapState, WhatIsMeasuredAndNotCorrectedComesBack) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 4};
  const Matrix P = star_covariance(layout, 4);
  PlanarMap map;
  map.reset(Vector::Zero(11), ArrowCovariance::of(P, layout));
  map.measure(1);
  map.measure(3);
  map.flush();
  EXPECT_EQ(map.measured_count(), 0);
  EXPECT_EQ(map.covariance().dense(), P);
}

TEST(BlockMapState, PredictsAllLandmarksThatItDoesNotTouch) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 4};
  const Matrix P = star_covariance(layout, 1);
  const Vector x = Vector::LinSpaced(11, 1.0, 11.0);
  PlanarMap map;
  map.reset(x, ArrowCovariance::of(P, layout));
  EXPECT_NEAR(map.trace(), 9.0 + 8.0, 1e-14);
  const Eigen::Matrix3d F{{1.0, 0.0, -0.5}, {0.0, 1.0, 2.0}, {0.0, 0.0, 1.0}};
  const Eigen::Matrix3d noise = Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal();
  Matrix all = Matrix::Identity(11, 11), expected = P;
  all.topLeftCorner(3, 3) = F;
  for (int k = 0; k < 3; ++k) {
    if (k == 1) EXPECT_EQ(map.measure(2), 0);  // one of them stands apart from here on
    map.predict(F, noise);
    expected = (all * expected * all.transpose()).eval();
    expected.topLeftCorner(3, 3) += noise;
  }
  EXPECT_LT((map.vehicle_covariance() - expected.topLeftCorner(3, 3)).norm(), 1e-13);
  EXPECT_LT((map.measured(0).cross - expected.block(0, 7, 3, 2)).norm(), 1e-13);
  EXPECT_EQ(map.measure(2), 0);
  EXPECT_EQ(map.measure(0), 1);
  EXPECT_EQ(map.measured_count(), 2);
  map.flush();
  EXPECT_EQ(map.measured_count(), 0);
  EXPECT_LT((map.covariance().dense() - expected).norm(), 1e-13);
  EXPECT_EQ(map.x(), x);
}

// With one landmark there is nothing to keep uncorrelated: all bounds but `drop` are the Kalman filter.
TEST(BlockMapState, OfOneLandmarkIsTheKalmanFilter) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 1};
  for (const MapBound bound : {MapBound::least_trace, MapBound::batch}) {
    DenseUpdate dense{.x = Vector::LinSpaced(5, 1.0, 5.0), .P = star_covariance(layout, 2), .gain = {}};
    PlanarMap map;
    map.reset(dense.x, ArrowCovariance::of(dense.P, layout));
    const Index seen = map.measure(0);
    const std::vector<PlanarMap::Scalar> scalars = {
        {.measured = seen, .h_r = {-1.0, 0.5, 0.2}, .h_l = {1.0, -0.5}, .nu = 0.7, .r = 0.4},
        {.measured = seen, .h_r = {0.3, -1.0, -1.0}, .h_l = {-0.3, 1.0}, .nu = -0.2, .r = 0.4},
        {.measured = -1, .h_r = {0.6, 0.8, 0.0}, .h_l = {0.0, 0.0}, .nu = 0.1, .r = 0.4},
        {.measured = -1, .h_r = {-0.8, 0.6, -1.0}, .h_l = {0.0, 0.0}, .nu = 1.5, .r = 0.4}};
    dense.correct({Vector{{-1.0, 0.5, 0.2, 1.0, -0.5}}, Vector{{0.3, -1.0, -1.0, -0.3, 1.0}},
                   Vector{{0.6, 0.8, 0.0, 0.0, 0.0}}, Vector{{-0.8, 0.6, -1.0, 0.0, 0.0}}},
                  {0.7, -0.2, 0.1, 1.5}, 0.4);
    Matrix gain;
    ASSERT_TRUE(map.correct(scalars, bound, &gain));
    EXPECT_LT((gain - dense.gain).norm(), 1e-12);
    const Eigen::Vector2d position = map.position(0);
    map.flush();
    EXPECT_LT((map.x() - dense.x).norm(), 1e-12);
    EXPECT_LT((position - dense.x.tail(2)).norm(), 1e-12);
    const Matrix after = map.covariance().dense();
    const double slack = bound == MapBound::batch ? 1e-6 : 1e-12;  // of the block ascent, upwards only
    EXPECT_LT((after - dense.P).norm(), slack);
    EXPECT_GT(least_eigenvalue_of(after - dense.P), -1e-12);
    EXPECT_NEAR(map.trace(), after.trace(), 1e-12);
  }
}

// What is exact of a scalar with any map: the state and all that belongs to the vehicle. The map lies above.
TEST(BlockMapState, TakesFromTheVehicleWhatTheKalmanFilterTakes) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 6};
  const Matrix P = star_covariance(layout, 3);
  Vector row = Vector::Zero(15);
  row.head(3) << -1.0, 0.5, 0.2;
  row.segment(7, 2) << 1.0, -0.5;
  for (const MapBound bound : {MapBound::least_trace, MapBound::drop}) {
    DenseUpdate dense{.x = Vector::Zero(15), .P = P, .gain = {}};
    PlanarMap map;
    map.reset(Vector::Zero(15), ArrowCovariance::of(P, layout));
    std::vector<PlanarMap::Scalar> scalars = {
        {.measured = map.measure(2), .h_r = row.head(3), .h_l = row.segment(7, 2), .nu = 0.9, .r = 0.3}};
    if (bound == MapBound::drop) {  // a further one, of an anchor, in the same pass
      scalars.push_back({.measured = -1, .h_r = {0.6, 0.8, -0.4}, .h_l = {0.0, 0.0}, .nu = -0.5, .r = 0.3});
      Vector second = Vector::Zero(15);
      second.head(3) << 0.6, 0.8, -0.4;
      dense.correct({row, second}, {0.9, -0.5}, 0.3);
    } else {
      dense.correct({row}, {0.9}, 0.3);
    }
    Matrix gain;
    ASSERT_TRUE(map.correct(scalars, bound, &gain));
    EXPECT_LT((gain - dense.gain).norm(), 1e-13);
    for (Index j = 0; j < 6; ++j)  // of those not measured before they are flushed, too
      EXPECT_LT((map.position(j) - dense.x.segment(3 + 2 * j, 2)).norm(), 1e-13) << j;
    map.flush();
    const Matrix after = map.covariance().dense();
    EXPECT_LT((map.x() - dense.x).norm(), 1e-13);
    EXPECT_LT((after.topRows(3) - dense.P.topRows(3)).norm(), 1e-13);
    EXPECT_GT(least_eigenvalue_of(after - dense.P), -1e-13);
    EXPECT_NEAR(map.trace(), after.trace(), 1e-13);
    if (bound == MapBound::drop) {
      EXPECT_LT((after.diagonal().tail(12) - P.diagonal().tail(12)).norm(), 1e-14);
    } else {
      // What the map may keep of its reduction: (a_i − L)², a_i the largest ‖(P hᵀ)_j‖/√s, L all others.
      const Vector column = P * row;
      double largest = 0.0, sum = 0.0;
      for (Index j = 0; j < 6; ++j) {
        const double norm = column.segment(3 + 2 * j, 2).norm();
        largest = std::max(largest, norm);
        sum += norm;
      }
      const double kept = 2.0 * largest - sum;
      ASSERT_GT(kept, 0.0);
      EXPECT_NEAR(12.0 - after.trace() + after.topLeftCorner(3, 3).trace(),
                  kept * kept / (row.dot(column) + 0.3), 1e-13);
    }
  }
}

TEST(BlockMapState, OnALineTheBoundOfLeastTraceIsThatOfItsFormula) {
  // h = (−1, 1, 0, 0) of P = diag(1) with P_rf = (0, 0.3, −0.1): s = 2 + r = 4, P hᵀ = (−1, 1, −0.3, 0.1).
  // Norms a = (1, 0.3, 0.1)/2 with 0.4/2 = L beside the largest: e₁ = a₁ L, e_j = a_j² + a_j (a₁ − L).
  Matrix P = Matrix::Identity(4, 4);
  P(0, 2) = P(2, 0) = 0.3;
  P(0, 3) = P(3, 0) = -0.1;
  LineMap map;
  map.reset(Vector::Zero(4), ArrowCovariance::of(P, {.vehicle = 1, .landmark = 1, .landmarks = 3}));
  LineMap::Scalar scalar{.measured = map.measure(0), .h_r = {}, .h_l = {}, .nu = 2.0, .r = 2.0};
  scalar.h_r[0] = -1.0;
  scalar.h_l[0] = 1.0;
  ASSERT_TRUE(map.correct(std::vector{scalar}, MapBound::least_trace, nullptr));
  map.flush();
  const Matrix after = map.covariance().dense();
  EXPECT_NEAR(after(0, 0), 1.0 - 0.25, 1e-15);
  EXPECT_NEAR(after(0, 1), 0.25, 1e-15);
  EXPECT_NEAR(after(0, 2), 0.3 - 0.3 / 4.0, 1e-15);
  EXPECT_NEAR(after(1, 1), 1.0 - 0.25 + 0.5 * 0.2, 1e-15);
  EXPECT_NEAR(after(2, 2), 1.0 + 0.15 * 0.3, 1e-15);
  EXPECT_NEAR(after(3, 3), 1.0 + 0.05 * 0.3, 1e-15);
  EXPECT_LT((map.x() - Vector{{-0.5, 0.5, -0.15, 0.05}}).norm(), 1e-15);
  EXPECT_NEAR(map.trace(), 4.0 - 0.25 - 0.3 * 0.3, 1e-15);
  // An innovation whose variance is none: P hᵀ h = 0.85 − 0.5 + 0.75 = 1.1 with r = −2.
  scalar.measured = map.measure(0);
  scalar.r = -2.0;
  EXPECT_FALSE(map.correct(std::vector{scalar}, MapBound::least_trace, nullptr));
}

TEST(BlockMapState, ANewLandmarkIsAboveItsExactCovariance) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 3};
  const Matrix P = star_covariance(layout, 4);
  PlanarMap map;
  map.reset(Vector::LinSpaced(9, 1.0, 9.0), ArrowCovariance::of(P, layout));
  const Eigen::Matrix<double, 2, 3> J{{1.0, 0.0, -0.7}, {0.0, 1.0, 0.4}};
  const Eigen::Matrix2d own = J * P.topLeftCorner(3, 3) * J.transpose() + 0.5 * Eigen::Matrix2d::Identity();
  map.append({20.0, 30.0}, J, own);
  ASSERT_EQ(map.landmarks(), 4);
  EXPECT_EQ(map.position(3), Eigen::Vector2d(20.0, 30.0));
  EXPECT_EQ(map.x().head(9), Vector::LinSpaced(9, 1.0, 9.0));
  Matrix exact = Matrix::Zero(11, 11);
  exact.topLeftCorner(9, 9) = P;
  exact.bottomLeftCorner(2, 9) = J * P.topRows(3);
  exact.topRightCorner(9, 2) = exact.bottomLeftCorner(2, 9).transpose();
  exact.bottomRightCorner(2, 2) = own;
  const Matrix bound = map.covariance().dense();
  EXPECT_LT((bound.topRows(3) - exact.topRows(3)).norm(), 1e-14);
  EXPECT_LT(bound.block(9, 3, 2, 6).norm(), 1e-300);
  EXPECT_GT(least_eigenvalue_of(bound - exact), -1e-14);
  // The least trace is twice the nuclear norms of the correlations that are taken away.
  double nuclear = 0.0;
  for (Index j = 0; j < 3; ++j) {
    const Eigen::Matrix2d C = exact.block(9, 3 + 2 * j, 2, 2);
    const double squared = C.squaredNorm() + 2.0 * std::abs(C.determinant());
    nuclear += std::sqrt(squared);  // (σ₁ + σ₂)² = ‖C‖² + 2 |det C|
  }
  EXPECT_NEAR(bound.trace() - exact.trace(), 2.0 * nuclear, 1e-13);
  EXPECT_NEAR(map.trace(), bound.trace(), 1e-13);
}

}  // namespace
}  // namespace credence::internal
