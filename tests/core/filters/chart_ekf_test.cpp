#include "core/filters/chart_ekf.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <random>

#include "core/manifold/se2.h"
#include "core/manifold/vector_group.h"

namespace credence::internal {
namespace {

constexpr std::array kCharts = {Chart::right, Chart::left, Chart::componentwise, Chart::componentwise_left};

/// A vehicle that moves by U and measures its position: all of it in chart c alone, with Jacobians by central
/// differences, as a textbook states the filter.
struct TextbookEkf {
  SE2 x;
  Eigen::Matrix3d P;
  Chart chart;

  template <class Function>
  static Matrix differences(const Function& f) {
    constexpr double kStep = 1e-5;
    Matrix J;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(i);
      const Vector change = (f(d) - f(-d)) / (2.0 * kStep);
      if (i == 0) J.resize(change.size(), 3);
      J.col(i) = change;
    }
    return J;
  }

  void predict(const SE2& U, const Eigen::Matrix3d& Q) {
    const SE2 moved = x * U;
    const Matrix F = differences(
        [&](const Eigen::Vector3d& d) { return Vector(minus(plus(x, d, chart) * U, moved, chart)); });
    const Matrix G = differences(
        [&](const Eigen::Vector3d& w) { return Vector(minus(moved * SE2::Exp(w), moved, chart)); });
    x = moved;
    P = F * P * F.transpose() + G * Q * G.transpose();
  }

  void update(const Eigen::Vector2d& z, const Eigen::Matrix2d& R) {
    const Matrix H =
        differences([&](const Eigen::Vector3d& d) { return Vector(plus(x, d, chart).translation()); });
    const Eigen::Matrix2d S = H * P * H.transpose() + R;
    const Matrix K = P * H.transpose() * S.inverse();
    x = plus(x, Eigen::Vector3d(K * (z - x.translation())), chart);
    P = (Eigen::Matrix3d::Identity() - K * H) * P;
  }
};

TEST(ChartEkf, IsTheTextbookFilterOfItsChart) {
  const Eigen::Matrix3d P0 = Eigen::Vector3d(0.5, 0.2, 0.4).asDiagonal();
  const Eigen::Matrix3d Q = Eigen::Vector3d(0.01, 0.02, 0.005).asDiagonal();
  const Eigen::Matrix2d R = 0.3 * Eigen::Matrix2d::Identity();
  const SE2 start(SO2(2.0), {3.0, -1.0}), U(SO2(0.3), {1.0, 0.1});
  std::array<SE2, kCharts.size()> ends;
  for (std::size_t c = 0; c < kCharts.size(); ++c) {
    TextbookEkf book{start, P0, kCharts[c]};
    ChartEkf<SE2> ekf(kCharts[c]);
    ekf.reset(start, P0, kCharts[c]);
    std::mt19937_64 generator(3);
    std::normal_distribution<double> normal;
    for (int k = 0; k < 20; ++k) {
      book.predict(U, Q);
      ekf.predict(ekf.state() * U, U.inverse().adjoint(), Q);
      const Eigen::Vector2d z(3.0 + normal(generator), 1.0 + normal(generator));
      book.update(z, R);
      ChartEkf<SE2>::Rows H(2, 3);
      H << ekf.state().rotation().matrix(), Eigen::Vector2d::Zero();
      ASSERT_TRUE(ekf.update(z - ekf.state().translation(), H, R));
      EXPECT_LT(minus(ekf.state(), book.x, Chart::right).norm(), 1e-7) << chart_name(kCharts[c]) << ' ' << k;
      EXPECT_LT((ekf.covariance(kCharts[c]) - book.P).norm(), 1e-7) << chart_name(kCharts[c]) << ' ' << k;
    }
    ends[c] = ekf.state();
  }
  EXPECT_GT(minus(ends[0], ends[1], Chart::right).norm(), 1e-4) << "the charts differ by their updates";
  EXPECT_LT(minus(ends[2], ends[3], Chart::right).norm(), 1e-12) << "in the plane both are one";
}

// With P carried along by each correction the left- and the right-invariant filter are one, without they are
// not; other charts stay apart.
TEST(ChartEkf, RightAndLeftAreOneFilterOnceCovariancesAreReset) {
  const Eigen::Matrix3d P0 = Eigen::Vector3d(0.5, 0.2, 0.4).asDiagonal();
  const Eigen::Matrix3d Q = Eigen::Vector3d(0.01, 0.02, 0.005).asDiagonal();
  const Eigen::Matrix2d R = 0.3 * Eigen::Matrix2d::Identity();
  const SE2 start(SO2(2.0), {3.0, -1.0}), U(SO2(0.3), {1.0, 0.1});
  const auto end = [&](Chart chart, CovarianceReset reset) {
    ChartEkf<SE2> ekf(chart, reset);
    ekf.reset(start, P0, Chart::right);
    for (int k = 0; k < 20; ++k) {
      ekf.predict(ekf.state() * U, U.inverse().adjoint(), Q);
      const Eigen::Vector2d z(3.0 + std::sin(k), 1.0 - std::cos(2.0 * k));
      ChartEkf<SE2>::Rows H(2, 3);
      H << ekf.state().rotation().matrix(), Eigen::Vector2d::Zero();
      EXPECT_TRUE(ekf.update(z - ekf.state().translation(), H, R));
    }
    return ekf;
  };
  for (const CovarianceReset reset : {CovarianceReset::none, CovarianceReset::full}) {
    const ChartEkf<SE2> right = end(Chart::right, reset), left = end(Chart::left, reset);
    const double apart = minus(right.state(), left.state(), Chart::right).norm() +
                         (right.covariance(Chart::right) - left.covariance(Chart::right)).norm();
    if (reset == CovarianceReset::full) {
      EXPECT_LT(apart, 1e-12);
    } else {
      EXPECT_GT(apart, 1e-4);
    }
  }
  const SE2 plain = end(Chart::componentwise, CovarianceReset::full).state();
  EXPECT_GT(minus(plain, end(Chart::right, CovarianceReset::full).state(), Chart::right).norm(), 1e-4);
}

TEST(ChartEkf, OnVectorsIsTheKalmanFilterInEveryChart) {
  using R2 = VectorGroup<2>;
  const Eigen::Matrix2d F = (Eigen::Matrix2d() << 1.0, 0.5, 0.0, 1.0).finished();
  const Eigen::Matrix2d Q = (Eigen::Matrix2d() << 0.2, 0.1, 0.1, 0.3).finished();
  for (const Chart chart : kCharts) {
    ChartEkf<R2> ekf(chart);
    Eigen::Vector2d x(1.0, 2.0);
    Eigen::Matrix2d P = Eigen::Vector2d(2.0, 1.0).asDiagonal();
    ekf.reset(R2(x), P, chart);
    for (int k = 0; k < 5; ++k) {
      x = F * x;
      P = F * P * F.transpose() + Q;
      ekf.predict(R2(F * ekf.state().vector()), F, Q);
      const double S = P(0, 0) + 0.5, nu = 0.3 * k - x[0];
      const Eigen::Vector2d K = P.col(0) / S;
      x += K * nu;
      P -= S * K * K.transpose();
      ASSERT_TRUE(
          ekf.update(Vector::Constant(1, nu), Eigen::RowVector2d(1.0, 0.0), Matrix::Constant(1, 1, 0.5)));
      EXPECT_NEAR(ekf.innovation_covariance()(0, 0), S, 1e-12);
    }
    EXPECT_LT((ekf.state().vector() - x).norm(), 1e-12);
    EXPECT_LT((ekf.covariance(chart) - P).norm(), 1e-12);
  }
}

TEST(ChartEkf, AnInnovationCovarianceThatIsNoneIsRefused) {
  ChartEkf<SE2> ekf(Chart::left);
  ekf.reset(SE2(), Eigen::Matrix3d::Zero(), Chart::left);
  EXPECT_FALSE(ekf.update(Vector::Zero(1), Eigen::RowVector3d(1.0, 0.0, 0.0), Matrix::Zero(1, 1)));
}

}  // namespace
}  // namespace credence::internal
