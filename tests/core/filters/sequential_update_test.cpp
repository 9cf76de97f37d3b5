#include "core/filters/sequential_update.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/linear_algebra/decompositions.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

constexpr MapBound kMapBounds[] = {MapBound::least_trace, MapBound::batch, MapBound::drop};

/// A prior whose landmarks are uncorrelated with each other, and scalars that each measure vehicle and one
/// landmark.
struct ScalarBatch {
  BlockLayout layout;
  Matrix P, H;
  Vector r;

  ScalarBatch(const BlockLayout& blocks, Index scalars, std::uint64_t seed) : layout(blocks) {
    const Index n = layout.state_dim(), nr = layout.vehicle, d = layout.landmark;
    // x_f,j = A_j x_r + what is its own
    const Matrix root = random_matrix(nr, nr, seed);
    P = Matrix::Zero(n, n);
    P.topLeftCorner(nr, nr) = 3.0 * root * root.transpose();
    for (Index j = 0; j < layout.landmarks; ++j) {
      const Index at = layout.landmark_offset(j);
      const Matrix A = 0.4 * random_matrix(d, nr, seed + 10 + static_cast<std::uint64_t>(j));
      const Matrix own = random_matrix(d, d, seed + 200 + static_cast<std::uint64_t>(j));
      P.block(at, 0, d, nr) = A * P.topLeftCorner(nr, nr);
      P.block(0, at, nr, d) = P.block(at, 0, d, nr).transpose();
      // what the other landmarks would have in common by the vehicle is taken from its variance alone
      P.block(at, at, d, d) = static_cast<double>(layout.landmarks) * A * P.block(0, at, nr, d) +
                              own * own.transpose() + 0.5 * Matrix::Identity(d, d);
    }
    H = Matrix::Zero(scalars, n);
    const Matrix of_vehicle = random_matrix(scalars, nr, seed + 1),
                 of_map = random_matrix(scalars, d, seed + 2);
    for (Index i = 0; i < scalars; ++i) {
      H.row(i).head(nr) = of_vehicle.row(i);
      H.row(i).segment(layout.landmark_offset(i / 2 % std::max<Index>(1, layout.landmarks - 1)), d) =
          of_map.row(i);
    }
    r = 0.1 + random_matrix(scalars, 1, seed + 3).array().square();
  }

  Index map() const { return P.rows() - layout.vehicle; }

  /// The Kalman filter's posterior and gain, of all scalars at once.
  Matrix kalman_gain() const {
    const Matrix S = H * P * H.transpose() + Matrix(r.asDiagonal());
    return P * H.transpose() * S.inverse();
  }
  Matrix kalman_posterior() const { return P - kalman_gain() * H * P; }
};

/// The theory's step by step, section 4, in dense matrices: D − l lᵀ of the map with the least trace, or as
/// it was.
Matrix map_after_scalar(const Matrix& P, const BlockLayout& layout, const Vector& l, MapBound which) {
  Matrix after = P - l * l.transpose();
  const Index nr = layout.vehicle, d = layout.landmark;
  Index largest = 0;
  double sum = 0.0;
  Vector a(layout.landmarks);
  for (Index j = 0; j < layout.landmarks; ++j) {
    a[j] = l.segment(nr + d * j, d).norm();
    sum += a[j];
    if (a[j] > a[largest]) largest = j;
  }
  const double others = sum - a[largest];
  for (Index i = 0; i < layout.landmarks; ++i) {
    for (Index j = 0; j < layout.landmarks; ++j) {
      auto block = after.block(nr + d * i, nr + d * j, d, d);
      if (i != j) {
        block.setZero();
        continue;
      }
      const Vector own = l.segment(nr + d * j, d);
      double e = a[j] * a[j];  // dropped
      if (which == MapBound::least_trace && a[largest] > others) {
        e = j == largest ? a[j] * others : a[j] * a[j] + a[j] * (a[largest] - others);
      }
      if (a[j] > 0.0) block += e / (a[j] * a[j]) * own * own.transpose();
    }
  }
  return after;
}

double smallest_eigenvalue_of(const Matrix& A) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(A, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

bool is_block_diagonal(const Matrix& P, const BlockLayout& layout) {
  Matrix map = P.bottomRightCorner(P.rows() - layout.vehicle, P.rows() - layout.vehicle);
  for (Index j = 0; j < map.rows(); j += layout.landmark) {
    map.block(j, j, layout.landmark, layout.landmark).setZero();
  }
  return map.isZero(0.0);
}

// Scalar by scalar, and the gain of the whole batch is what the scalars do one after the other to an
// estimate.
TEST(SequentialUpdate, IsTheTheoryScalarByScalar) {
  for (const MapBound which : {MapBound::least_trace, MapBound::drop}) {
    for (const Index d : {1, 2}) {
      for (std::uint64_t seed = 1; seed < 6; ++seed) {
        const ScalarBatch at({.vehicle = d == 1 ? 1 : 3, .landmark = d, .landmarks = 4}, 5, 1000 * seed);
        Matrix P = at.P, K(P.rows(), 5), expected = at.P;
        SequentialWorkspace workspace;
        ASSERT_TRUE(sequential_update(P, at.layout, at.H, at.r, K, workspace, which));
        const Vector nu = random_matrix(5, 1, seed);
        Vector x = Vector::Zero(P.rows());
        for (Index i = 0; i < 5; ++i) {
          const Vector ph = expected * at.H.row(i).transpose();
          const double s = at.H.row(i).dot(ph) + at.r[i];
          x += ph / s * (nu[i] - at.H.row(i).dot(x));
          expected = map_after_scalar(expected, at.layout, ph / std::sqrt(s), which);
        }
        EXPECT_LT((P - expected).norm(), 1e-12 * expected.norm()) << d << " " << seed;
        EXPECT_LT((K * nu - x).norm(), 1e-12 * (1.0 + x.norm())) << d << " " << seed;
      }
    }
  }
}

// Whatever bound the map takes: it stays block diagonal, and P is no less than what the Kalman filter has.
TEST(SequentialUpdate, NoBoundIsBelowTheKalmanFilter) {
  for (const MapBound which : kMapBounds) {
    for (const Index d : {1, 2}) {
      for (std::uint64_t seed = 1; seed < 9; ++seed) {
        const ScalarBatch at({.vehicle = d == 1 ? 1 : 3, .landmark = d, .landmarks = 5}, 6, 100 * seed);
        ASSERT_GT(smallest_eigenvalue_of(at.P), 0.0);
        Matrix P = at.P, K(P.rows(), 6);
        SequentialWorkspace workspace;
        ASSERT_TRUE(sequential_update(P, at.layout, at.H, at.r, K, workspace, which));
        EXPECT_TRUE(is_block_diagonal(P, at.layout));
        EXPECT_GT(smallest_eigenvalue_of(P - at.kalman_posterior()), -1e-12 * at.P.trace()) << seed;
        EXPECT_LE(P.diagonal().tail(at.map()).sum(), at.P.diagonal().tail(at.map()).sum() * (1.0 + 1e-14));
        // The error that this gain leaves is covered.
        const Matrix A = Matrix::Identity(P.rows(), P.rows()) - K * at.H;
        const Matrix left = A * at.P * A.transpose() + K * at.r.asDiagonal() * K.transpose();
        EXPECT_GT(smallest_eigenvalue_of(P - left), -1e-12 * at.P.trace()) << seed;
      }
    }
  }
}

// A batch as a whole is the Kalman filter but for the map's own blocks.
TEST(SequentialUpdate, ABatchHasTheKalmanFiltersGainAndVehicle) {
  for (const Index d : {1, 2}) {
    const ScalarBatch at({.vehicle = d == 1 ? 1 : 3, .landmark = d, .landmarks = 6}, 8, 77);
    Matrix P = at.P, K(P.rows(), 8);
    SequentialWorkspace workspace;
    ASSERT_TRUE(sequential_update(P, at.layout, at.H, at.r, K, workspace, MapBound::batch));
    const Matrix exact = at.kalman_posterior();
    const Index nr = at.layout.vehicle;
    EXPECT_LT((K - at.kalman_gain()).norm(), 1e-12 * K.norm());
    EXPECT_LT((P.topRows(nr) - exact.topRows(nr)).norm(), 1e-12 * exact.norm());
    EXPECT_LT((P.leftCols(nr) - exact.leftCols(nr)).norm(), 1e-12 * exact.norm());
  }
}

// More scalars than a batch takes at once go in groups: each by what the group before has left.
TEST(SequentialUpdate, ALargeBatchGoesInGroups) {
  const ScalarBatch at({.vehicle = 3, .landmark = 2, .landmarks = 24}, 44, 5);
  Matrix P = at.P, K(P.rows(), 44);
  SequentialWorkspace workspace;
  ASSERT_TRUE(sequential_update(P, at.layout, at.H, at.r, K, workspace, MapBound::batch));
  Matrix expected = at.P;
  Vector x = Vector::Zero(P.rows());
  const Vector nu = random_matrix(44, 1, 9);
  for (Index first = 0; first < 44; first += 22) {  // of equal size
    Matrix gain(P.rows(), 22);
    const Matrix before = expected;
    ASSERT_TRUE(sequential_update(expected, at.layout, at.H.middleRows(first, 22), at.r.segment(first, 22),
                                  gain, workspace, MapBound::batch));
    x += gain * (nu.segment(first, 22) - at.H.middleRows(first, 22) * x);
  }
  EXPECT_LT((P - expected).norm(), 1e-12 * P.norm());
  EXPECT_LT((K * nu - x).norm(), 1e-11 * (1.0 + x.norm()));
}

TEST(SequentialUpdate, NothingMeasuredChangesNothing) {
  for (const MapBound which : kMapBounds) {
    const ScalarBatch at({.vehicle = 3, .landmark = 2, .landmarks = 3}, 2, 4);
    Matrix P = at.P, K(P.rows(), 0);
    SequentialWorkspace workspace;
    EXPECT_TRUE(sequential_update(P, at.layout, Matrix(0, P.rows()), Vector(0), K, workspace, which));
    EXPECT_EQ(P, at.P);
  }
}

TEST(SequentialUpdate, SaysWhenAnInnovationHasNoVariance) {
  for (const MapBound which : kMapBounds) {
    for (const double bad : {-1e6, std::nan("")}) {
      ScalarBatch at({.vehicle = 3, .landmark = 2, .landmarks = 3}, 4, 4);
      at.r[2] = bad;
      Matrix P = at.P, K(P.rows(), 4);
      SequentialWorkspace workspace;
      EXPECT_FALSE(sequential_update(P, at.layout, at.H, at.r, K, workspace, which)) << bad;
    }
  }
}

}  // namespace
}  // namespace credence::internal
