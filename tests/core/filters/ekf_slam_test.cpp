#include "core/filters/ekf_slam.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <vector>

#include "core/filters/linear_filter.h"
#include "tests/core/filters/golden_problem.h"

namespace credence {
namespace {

using PlanarEkf = EkfSlam<PlanarModel>;
using PlanarObservation = Observation<PlanarModel>;

class EkfSlamGolden : public testing::TestWithParam<GoldenStep> {};

TEST_P(EkfSlamGolden, HoldsToTheDigitsGiven) {
  const GoldenStep& golden = GetParam();
  GoldenProblem problem(golden.landmarks);
  auto filter = problem.make_filter<PlanarEkf>();
  for (int k = 0; k < 10; ++k) problem.step(filter, k, golden.m);
  EXPECT_NEAR(filter.state().sum() / golden.sum, 1.0, 2e-9);
  EXPECT_NEAR(filter.covariance().trace() / golden.trace, 1.0, 4e-9);
  EXPECT_EQ(filter.covariance(), filter.covariance().transpose());
}

INSTANTIATE_TEST_SUITE_P(SevenImplementations, EkfSlamGolden, testing::ValuesIn(kGoldenSteps));

TEST(EkfSlam, OnTheMonobotItIsTheLinearFilter) {
  const Index N = 3;
  for (const Inflation inflation : {Inflation::none, Inflation::map, Inflation::full}) {
    InflationRule rule;
    rule.inflation = inflation;
    using Scalar = MonobotModel::Scalar;
    const std::vector<Anchor<MonobotModel>> anchors = {{10, Scalar(4.0)}};
    EkfSlam<MonobotModel> filter({}, Scalar(0.2), Scalar(0.1), rule, anchors);
    const std::vector<int> ids = {0, 1, 2};
    filter.reset(Vector::Zero(1 + N), Matrix::Identity(1 + N, 1 + N), ids);
    const auto steps = linear_filter_steps(monobot_model(N, 1, 0.2, 0.1, 1.0), rule, 30);
    for (const LinearFilterStep& step : steps) {
      filter.predict(Scalar(0.1));
      std::vector<Observation<MonobotModel>> z;
      for (const int id : {10, 0, 1, 2}) z.push_back({id, Scalar(0.3 * id)});
      const UpdateResult result = filter.update(z);
      EXPECT_NEAR(result.trace_prior, step.P_prior.trace(), 1e-12);
      EXPECT_LT((filter.covariance() - step.P).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_LT((filter.gain() - step.K).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

TEST(EkfSlam, InitialisationIsTheLimitOfAnUninformativePrior) {
  // A landmark that is in the state with a huge variance at the right place, and then measured, is what
  // initialisation at first sight gives.
  const PlanarModel model{.vehicle = {}, .dt_s = 0.1};
  const Eigen::Matrix2d Q = 0.01 * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d R = Eigen::Vector2d(0.01, 0.0004).asDiagonal();
  const Pose pose(1.0, 2.0, 0.5);
  const Eigen::Matrix3d P = Eigen::Vector3d(0.02, 0.03, 0.001).asDiagonal();
  const RangeBearing z(5.0, 0.7);
  const std::vector<PlanarObservation> seen = {{4, z}};

  PlanarEkf first_sight(model, Q, R);
  first_sight.reset(pose, P);
  EXPECT_EQ(first_sight.update(seen).initialised, 1);

  PlanarEkf prior(model, Q, R);
  Vector x(5);
  x << pose, place_landmark(pose, z).position;
  Matrix P_prior = Matrix::Zero(5, 5);
  P_prior.topLeftCorner<3, 3>() = P;
  constexpr double kHuge = 1e6;
  P_prior.bottomRightCorner<2, 2>() = kHuge * Eigen::Matrix2d::Identity();
  prior.reset(x, P_prior, std::vector<int>{4});
  ASSERT_TRUE(prior.update(seen).ok);

  EXPECT_LT((first_sight.state() - prior.state()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((first_sight.covariance() - prior.covariance()).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(EkfSlam, AnAnchorIsNoStateAndPinsThePose) {
  const PlanarModel model{.vehicle = {}, .dt_s = 0.1};
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  const std::vector<Anchor<PlanarModel>> anchors = {{0, Point(5.0, 0.0)}, {1, Point(0.0, 5.0)}};
  PlanarEkf filter(model, 0.01 * I, 1e-4 * I, {}, anchors);
  filter.reset(Pose::Zero(), Eigen::Matrix3d::Identity());
  const std::vector<PlanarObservation> z = {{0, measure_range_bearing(Pose::Zero(), {5.0, 0.0})},
                                            {1, measure_range_bearing(Pose::Zero(), {0.0, 5.0})}};
  const UpdateResult result = filter.update(z);
  EXPECT_TRUE(result.ok);
  EXPECT_EQ(result.dof, 4);
  EXPECT_EQ(filter.state().size(), 3);
  EXPECT_LT(filter.covariance().diagonal().maxCoeff(), 0.01);
}

TEST(EkfSlam, AnInnovationCovarianceThatIsNotPositiveDefiniteIsDataAndChangesNothing) {
  PlanarEkf filter({.vehicle = {}, .dt_s = 0.1}, Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero());
  filter.reset(Pose::Zero(), Eigen::Matrix3d::Zero());
  const std::vector<PlanarObservation> seen = {{0, RangeBearing(3.0, 0.1)}};
  ASSERT_TRUE(filter.update(seen).ok);
  const Vector x = filter.state();
  const UpdateResult again = filter.update(seen);
  EXPECT_FALSE(again.ok);
  EXPECT_EQ(filter.state(), x);
}

TEST(EkfSlam, SizesThatDoNotMatchAreRefused) {
  PlanarEkf filter({.vehicle = {}, .dt_s = 0.1}, Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity());
  EXPECT_THROW(filter.reset(Vector::Zero(4), Matrix::Identity(4, 4), std::vector<int>{0}),
               std::invalid_argument);
  EXPECT_THROW(filter.update(std::vector<PlanarObservation>{{-1, RangeBearing(1.0, 0.0)}}),
               std::invalid_argument);
}

TEST(EkfSlam, SequentialInflationKeepsLandmarksUncorrelatedAndPositiveDefinite) {
  InflationRule rule;
  rule.inflation = Inflation::map;
  rule.solution = InflationSolution::sequential;
  const PlanarModel model{.vehicle = {}, .dt_s = 0.1};
  const Eigen::Matrix2d Q = 0.01 * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d R = Eigen::Vector2d(0.01, 0.0004).asDiagonal();
  PlanarEkf filter(model, Q, R, rule);
  filter.reset(Pose::Zero(), 0.01 * Eigen::Matrix3d::Identity());
  const std::vector<Point> landmarks = {{4.0, 1.0}, {5.0, -2.0}, {2.0, 3.0}};
  Pose truth = Pose::Zero();
  for (int k = 0; k < 40; ++k) {
    const Control u(1.0, 0.2);
    truth = model.vehicle.moved(truth, u, model.dt_s);
    filter.predict(u);
    std::vector<PlanarObservation> z;
    for (int i = 0; i <= std::min(k, 2); ++i) {
      z.push_back({i, measure_range_bearing(truth, landmarks[static_cast<std::size_t>(i)])});
    }
    ASSERT_TRUE(filter.update(z).ok);
    const Matrix& P = filter.covariance();
    for (Index i = 3; i < P.rows(); i += 2) {
      for (Index j = 3; j < i; j += 2) EXPECT_TRUE((P.block<2, 2>(i, j).isZero(0.0))) << "step " << k;
    }
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix>(P).eigenvalues().minCoeff(), 0.0);
  }
  EXPECT_LT((filter.pose() - truth).norm(), 1e-6);
}

}  // namespace
}  // namespace credence
