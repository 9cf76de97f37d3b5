#include "analysis/studies/textbook_ekf.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

using PlanarObservation = Observation<PlanarModel>;

constexpr int kMapSize = 6;
const Eigen::Matrix2d kControlNoise = Eigen::Vector2d(0.01, 0.0004).asDiagonal();
const Eigen::Matrix2d kObservationNoise = Eigen::Vector2d(0.02, 0.0005).asDiagonal();

PlanarModel turning_model() { return {.vehicle = {}, .dt_s = 0.5}; }

/// A pose that looks along −x, so that headings and bearings cross ±π, within a ring of landmarks.
Vector known_map() {
  Vector x(3 + 2 * kMapSize);
  x.head<3>() = Pose(0.5, -0.2, std::numbers::pi - 0.05);
  for (int i = 0; i < kMapSize; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kMapSize;
    x.segment<2>(3 + 2 * i) = Point(8.0 * std::cos(angle), 6.0 * std::sin(angle));
  }
  return x;
}

Matrix correlated_covariance(Index n) {
  Matrix L = 0.1 * Matrix::Identity(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < i; ++j) L(i, j) = 0.02 * std::sin(static_cast<double>(3 * i + 5 * j));
  }
  return L * L.transpose();
}

const std::vector<int> kIds{7, 3, 11, 2, 20, 5};

std::vector<PlanarObservation> observations_of(const Vector& x, std::initializer_list<int> places, int step) {
  std::vector<PlanarObservation> observations;
  for (const int place : places) {
    const Point landmark = x.segment<2>(3 + 2 * place);
    Eigen::Vector2d z = turning_model().predict(x.head<3>(), landmark).z;
    z += Eigen::Vector2d(0.1 * std::sin(step + place), 0.02 * std::cos(2.0 * step - place));
    z[1] = wrap_angle(z[1]);
    observations.push_back({.landmark = kIds[static_cast<std::size_t>(place)], .z = z});
  }
  return observations;
}

TEST(TextbookEkf, IsTheFastFilterOfAKnownMap) {
  const Vector x = known_map();
  const Matrix P = correlated_covariance(x.size());
  TextbookEkf book(turning_model(), kControlNoise, kObservationNoise);
  EkfSlam<PlanarModel> fast(turning_model(), kControlNoise, kObservationNoise);
  book.reset(x, P, kIds);
  fast.reset(x, P, kIds);
  EXPECT_EQ(book.offset_of(11), 7);
  for (int k = 0; k < 30; ++k) {
    const Control u(0.6, 0.3 * std::cos(k));
    const auto observations = observations_of(fast.state(), {k % kMapSize, (k + 2) % kMapSize}, k);
    book.predict(u);
    fast.predict(u);
    const UpdateResult of_book = book.update(observations), of_fast = fast.update(observations);
    ASSERT_TRUE(of_book.ok && of_fast.ok);
    EXPECT_EQ(of_book.dof, of_fast.dof);
    EXPECT_NEAR(of_book.nis, of_fast.nis, 1e-8 * (1.0 + of_fast.nis)) << k;
    EXPECT_NEAR(of_book.trace_prior, of_fast.trace_prior, 1e-11) << k;
    ASSERT_LT((book.covariance() - fast.covariance()).norm(), 1e-11) << k;
    Vector difference = book.state() - fast.state();
    difference[2] = wrap_angle(difference[2]);
    ASSERT_LT(difference.norm(), 1e-10) << k;
    EXPECT_EQ(book.covariance(), book.covariance().transpose());
    EXPECT_LE(std::abs(book.pose()[2]), std::numbers::pi);
  }
}

TEST(TextbookEkf, UpdatesTheInformation) {
  const Vector x = known_map();
  const Matrix P = correlated_covariance(x.size());
  TextbookEkf book(turning_model(), kControlNoise, kObservationNoise);
  book.reset(x, P, kIds);
  const auto observations = observations_of(x, {4}, 1);
  const auto predicted = turning_model().predict(x.head<3>(), x.segment<2>(11));
  Matrix H = Matrix::Zero(2, x.size());
  H.leftCols<3>() = predicted.H_r;
  H.middleCols<2>(11) = predicted.H_l;
  Eigen::Vector2d nu = observations.front().z - predicted.z;
  nu[1] = wrap_angle(nu[1]);
  const UpdateResult result = book.update(observations);
  const Matrix S = H * P * H.transpose() + kObservationNoise;
  EXPECT_NEAR(result.nis, nu.dot(S.inverse() * nu), 1e-12);
  EXPECT_EQ(result.dof, 2);
  const Matrix posterior = (P.inverse() + H.transpose() * kObservationNoise.inverse() * H).inverse();
  EXPECT_LT((book.covariance() - posterior).norm(), 1e-10);
  Vector wanted = x + posterior * H.transpose() * kObservationNoise.inverse() * nu;
  wanted[2] = wrap_angle(wanted[2]);
  EXPECT_LT((book.state() - wanted).norm(), 1e-9);
}

TEST(TextbookEkf, LeavesWhatItCannotUpdate) {
  const Vector x = known_map();
  TextbookEkf book(turning_model(), kControlNoise, Eigen::Matrix2d::Zero());
  book.reset(x, Matrix::Zero(x.size(), x.size()), kIds);
  EXPECT_FALSE(book.update(observations_of(x, {1}, 1)).ok);
  EXPECT_EQ(book.state(), x);
  EXPECT_EQ(book.covariance().norm(), 0.0);
}

}  // namespace
}  // namespace credence::internal
