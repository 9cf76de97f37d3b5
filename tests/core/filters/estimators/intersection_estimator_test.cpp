#include "core/filters/estimators/intersection_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/filters/estimators/estimator_tour.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

/// Of one observation: what is dependent and independent of the vehicle's covariance, and the landmark's.
struct Parts {
  Matrix D, I, P_l, H_r, H_l, R;

  Matrix joint(double omega) const {
    Matrix B = Matrix::Zero(5, 5);
    B.topLeftCorner(3, 3) = D / omega + I;
    B.bottomRightCorner(2, 2) = P_l / (1.0 - omega);
    return B;
  }
  /// Kalman's correction of diag(D/ω + I, P_l/(1 − ω)).
  Matrix corrected(double omega) const {
    Matrix H(2, 5);
    H << H_r, H_l;
    return TextbookCorrection(joint(omega), H, Vector::Zero(2), R).P;
  }
  /// Over a grid as fine as the estimator's search, the least Σ of the variances over those before.
  double best_omega(Index first, Index count, const Vector& before) const {
    double best = 0.0, least = std::numeric_limits<double>::infinity();
    for (double omega = 5e-4; omega < 1.0; omega += 5e-4) {
      const double cost =
          corrected(omega).diagonal().segment(first, count).cwiseQuotient(before.segment(first, count)).sum();
      if (cost < least) {
        least = cost;
        best = omega;
      }
    }
    return best;
  }
};

class IntersectionTest : public testing::TestWithParam<LandmarkSensorKind> {};
INSTANTIATE_TEST_SUITE_P(Sensors, IntersectionTest,
                         testing::Values(LandmarkSensorKind::relative_position,
                                         LandmarkSensorKind::range_bearing));

/// A filter that has seen three landmarks one by one, and what of its P is independent: the noise of the last
/// motion.
struct IntersectionScene {
  EstimatorTour tour;
  IntersectionEstimator filter;
  Parts parts;
  Vector x;
  Matrix P;

  explicit IntersectionScene(LandmarkSensorKind sensor, double noise = 1.0)
      : tour(sensor), filter((tour.settings.Q *= noise, tour.settings)) {
    filter.reset(tour.now + Pose(0.1, -0.05, 0.03), EstimatorTour::initial_covariance());
    for (const int number : {0, 3, 1, 0, 3}) {
      filter.predict(tour.drive(), tour.truth());
      filter.update(tour.see({number}), tour.truth());
    }
    const Pose from = filter.state().head<3>();
    const Control read = tour.drive();
    filter.predict(read, tour.truth());
    x = filter.state();
    P = whole_covariance(filter);
    const Matrix G = textbook_control_jacobian(tour.settings.model, from, read);
    const Index l = filter.offset_of(1);
    const Matrix H = textbook_jacobian(tour.settings, x, std::vector<Index>{l});
    parts.I = G * tour.settings.Q * G.transpose();
    parts.D = P.topLeftCorner(3, 3) - parts.I;
    parts.P_l = P.block(l, l, 2, 2);
    parts.H_r = H.leftCols(3);
    parts.H_l = H.middleCols(l, 2);
    parts.R = tour.settings.R;
  }
};

// Vehicle and landmark each by the ω that is best for it, found here by looking at all of them.
TEST_P(IntersectionTest, takes_the_best_of_all_bounds) {
  for (const double noise : {1.0, 30.0}) {
    IntersectionScene scene(GetParam(), noise);
    const auto& [tour, filter, parts, x, P] = scene;
    const Index l = filter.offset_of(1);
    Vector before(5);
    before << P.diagonal().head(3), P.diagonal().segment(l, 2);
    const auto observations = scene.tour.see({1});
    ASSERT_TRUE(scene.filter.update(observations, tour.truth()).ok);

    const Matrix after = whole_covariance(filter);
    const Matrix of_vehicle = parts.corrected(parts.best_omega(0, 3, before)).topLeftCorner(3, 3);
    const Matrix of_landmark = parts.corrected(parts.best_omega(3, 2, before)).bottomRightCorner(2, 2);
    EXPECT_LT((after.topLeftCorner(3, 3) - of_vehicle).norm(), 5e-3 * of_vehicle.norm()) << noise;
    EXPECT_LT((after.block(l, l, 2, 2) - of_landmark).norm(), 5e-3 * of_landmark.norm()) << noise;
    // at the least the cost is flat, and no more than without the observation
    const auto cost = [](const Matrix& A, const Vector& of) { return A.diagonal().cwiseQuotient(of).sum(); };
    EXPECT_NEAR(cost(after.topLeftCorner(3, 3), before.head(3)),
                std::min(3.0, cost(of_vehicle, before.head(3))), 2e-5);
    EXPECT_NEAR(cost(after.block(l, l, 2, 2), before.tail(2)),
                std::min(2.0, cost(of_landmark, before.tail(2))), 2e-5);
    EXPECT_LE(cost(after.topLeftCorner(3, 3), before.head(3)), 3.0 + 1e-12);
    EXPECT_LE(cost(after.block(l, l, 2, 2), before.tail(2)), 2.0 + 1e-12);
    // other landmarks stand
    for (const int other : {0, 3}) {
      const Index j = filter.offset_of(other);
      EXPECT_EQ(filter.state().segment<2>(j), x.segment<2>(j));
      EXPECT_EQ(after.block(j, j, 2, 2), P.block(j, j, 2, 2));
    }
  }
}

// Whatever correlates D with P_l, blocks no larger than they claim to be: by the gains that were used the
// errors stay within what the filter says.
TEST_P(IntersectionTest, bounds_the_error_for_every_correlation) {
  IntersectionScene scene(GetParam(), 5.0);
  const Parts& parts = scene.parts;
  ASSERT_TRUE(scene.filter.update(scene.tour.see({1}), scene.tour.truth()).ok);
  const Matrix K = scene.filter.gain(), after = whole_covariance(scene.filter);
  const Index l = scene.filter.offset_of(1);
  const Matrix root = parts.D.selfadjointView<Eigen::Lower>().ldlt().reconstructedMatrix().llt().matrixL();
  const Matrix root_l = parts.P_l.llt().matrixL();
  for (std::uint64_t seed = 1; seed < 40; ++seed) {
    const Eigen::JacobiSVD<Matrix> svd(random_matrix(3, 2, seed), Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Matrix C = root * svd.matrixU() * svd.matrixV().transpose() * root_l.transpose();  // the strongest
    Matrix truth(5, 5);
    truth << parts.D + parts.I, C, C.transpose(), parts.P_l;
    const auto gap = [&](const Matrix& gain, Index first, Index count, const Matrix& claimed) {
      Matrix T = Matrix::Identity(5, 5).middleRows(first, count), H(2, 5);
      H << parts.H_r, parts.H_l;
      T -= gain * H;
      const Matrix left = T * truth * T.transpose() + gain * parts.R * gain.transpose();
      return Eigen::SelfAdjointEigenSolver<Matrix>(claimed - left).eigenvalues()(0) / claimed.trace();
    };
    EXPECT_GT(gap(K.topRows(3), 0, 3, after.topLeftCorner(3, 3)), -1e-9) << seed;
    EXPECT_GT(gap(K.middleRows(l, 2), 3, 2, after.block(l, l, 2, 2)), -1e-9) << seed;
  }
}

// A landmark that is known far better than the vehicle learns nothing from being seen, however often: its
// variance must not creep up by the last thousandth of ω, 5·10⁻⁴ at every observation.
TEST(IntersectionEstimator, an_observation_without_news_takes_nothing_away) {
  EstimatorTour tour(LandmarkSensorKind::relative_position);
  IntersectionEstimator filter(tour.settings);
  filter.reset(tour.now, 1e-6 * EstimatorTour::initial_covariance());
  filter.update(tour.see_exactly({0}), tour.truth());
  const Matrix P_l = whole_covariance(filter).bottomRightCorner(2, 2);
  for (int k = 0; k < 400; ++k) {
    if (k < 20) filter.set_interval(30.0);  // the vehicle loses its way
    filter.predict(Control::Zero(), tour.truth());
    ASSERT_TRUE(filter.update(tour.see_exactly({0}), tour.truth()).ok);
    EXPECT_LE(whole_covariance(filter).bottomRightCorner(2, 2).trace(), P_l.trace() * (1.0 + 1e-12)) << k;
    if (HasFailure()) break;
  }
}

// The second landmark of the batch coincides with the vehicle, where its bearing has no Jacobian.
TEST(IntersectionEstimator, a_correction_that_fails_changes_nothing) {
  EstimatorTour tour(LandmarkSensorKind::range_bearing);
  tour.now = tour.before = Pose::Zero();
  IntersectionEstimator filter(tour.settings);
  filter.reset(tour.now, EstimatorTour::initial_covariance());
  const EstimatorTour::Observations ahead{{0, {4.0, 0.25}}, {1, {2.0, 0.0}}};
  ASSERT_TRUE(filter.update(ahead, tour.truth()).ok);
  filter.predict({2.0 / tour.settings.model.dt_s, 0.0}, tour.truth());
  const Vector x = filter.state();
  const Matrix P = whole_covariance(filter);
  ASSERT_EQ(x.segment<2>(filter.offset_of(1)), x.head<2>());
  const Point away = x.segment<2>(filter.offset_of(0)) - x.head<2>();
  const EstimatorTour::Observations seen{{0, tour.settings.sensor.measure(away)}, {1, {0.1, 0.0}}};
  EXPECT_FALSE(filter.update(seen, tour.truth()).ok);
  EXPECT_EQ(filter.state(), x);
  EXPECT_EQ(whole_covariance(filter), P);
  // Nor is the noise of the motion forgotten: what comes next is as if nothing had been seen.
  IntersectionEstimator other(tour.settings);
  other.reset(tour.now, EstimatorTour::initial_covariance());
  other.update(ahead, tour.truth());
  other.predict({2.0 / tour.settings.model.dt_s, 0.0}, tour.truth());
  const EstimatorTour::Observations first{seen.front()};
  ASSERT_TRUE(filter.update(first, tour.truth()).ok);
  ASSERT_TRUE(other.update(first, tour.truth()).ok);
  EXPECT_EQ(whole_covariance(filter), whole_covariance(other));
}

// What a landmark has told makes the whole of the vehicle's error dependent: without a motion a second
// observation has no independent part.
TEST_P(IntersectionTest, has_no_independent_part_after_an_observation) {
  IntersectionScene scene(GetParam());
  ASSERT_TRUE(scene.filter.update(scene.tour.see({1}), scene.tour.truth()).ok);
  const Vector x = scene.filter.state();
  const Matrix P = whole_covariance(scene.filter);
  const Index l = scene.filter.offset_of(0);
  const Matrix H = textbook_jacobian(scene.tour.settings, x, std::vector<Index>{l});
  const Parts parts{P.topLeftCorner(3, 3), Matrix::Zero(3, 3), P.block(l, l, 2, 2),
                    H.leftCols(3),         H.middleCols(l, 2), scene.tour.settings.R};
  Vector before(5);
  before << P.diagonal().head(3), P.diagonal().segment(l, 2);
  ASSERT_TRUE(scene.filter.update(scene.tour.see({0}), scene.tour.truth()).ok);
  const Matrix after = whole_covariance(scene.filter);
  const Matrix of_vehicle = parts.corrected(parts.best_omega(0, 3, before)).topLeftCorner(3, 3);
  EXPECT_LT((after.topLeftCorner(3, 3) - of_vehicle).norm(), 5e-3 * of_vehicle.norm());
}

}  // namespace
}  // namespace credence::internal
