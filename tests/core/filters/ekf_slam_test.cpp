#include "core/filters/ekf_slam.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/filters/block_map_ekf_slam.h"
#include "core/filters/linear_filter.h"
#include "core/manifold/angle.h"
#include "tests/core/filters/golden_problem.h"

namespace credence::internal {
namespace {

using PlanarEkf = EkfSlam<PlanarModel>;
using PlanarObservation = Observation<PlanarModel>;

std::vector<InstructionSet> supported_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) sets.push_back(set);
  }
  return sets;
}

/// A unicycle that circles among landmarks and sees the next `observed` of them, noise included.
class PlanarLoop {
 public:
  PlanarLoop(int landmarks, int observed, double noise = 1.0)
      : landmarks_(landmarks), observed_(observed), noise_(noise) {
    for (int i = 0; i < landmarks; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / landmarks;
      const double radius = i % 2 == 0 ? 14.0 : 6.0;
      places_.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
  }

  Eigen::Matrix2d Q() const { return noise_ * noise_ * Eigen::Vector2d(0.01, 0.0001).asDiagonal(); }
  Eigen::Matrix2d R() const { return noise_ * noise_ * Eigen::Vector2d(0.01, 0.0003).asDiagonal(); }
  PlanarModel model() const { return {.vehicle = {}, .dt_s = 0.1}; }
  Pose start() const { return {10.0, 0.0, 0.5 * std::numbers::pi}; }
  const Point& place(int landmark) const { return places_[static_cast<std::size_t>(landmark)]; }

  template <class Filter, class... Options>
  Filter make_filter(const Options&... options) const {
    Filter filter(model(), Q(), R(), options...);
    filter.reset(start(), noise_ * noise_ * Eigen::Vector3d(0.01, 0.01, 0.0001).asDiagonal().toDenseMatrix());
    return filter;
  }

  /// The true control of a step, once round in about 63 of them.
  Control control() const { return {10.0, 1.0}; }

  std::vector<PlanarObservation> observe() {
    truth_ = model().vehicle.moved(truth_, control() + 0.1 * noise_ * noise(), 0.1);
    std::vector<PlanarObservation> z;
    for (int i = 0; i < observed_; ++i) {
      const int id = (step_ / 2 + i) % landmarks_;
      const RangeBearing exact = measure_range_bearing(truth_, place(id));
      const RangeBearing noisy = exact + 0.1 * noise_ * noise();
      z.push_back({id, {noisy[0], wrap_angle(noisy[1])}});
    }
    ++step_;
    return z;
  }

 private:
  Eigen::Vector2d noise() {
    const double first = normal_(generator_), second = normal_(generator_);
    return {first, 0.17 * second};
  }

  int landmarks_, observed_, step_ = 0;
  double noise_;
  std::vector<Point> places_;
  Pose truth_ = start();
  std::mt19937_64 generator_{7};
  std::normal_distribution<double> normal_;
};

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
  // initialisation at first observation gives.
  const PlanarModel model{.vehicle = {}, .dt_s = 0.1};
  const Eigen::Matrix2d Q = 0.01 * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d R = Eigen::Vector2d(0.01, 0.0004).asDiagonal();
  const Pose pose(1.0, 2.0, 0.5);
  const Eigen::Matrix3d P = Eigen::Vector3d(0.02, 0.03, 0.001).asDiagonal();
  const RangeBearing z(5.0, 0.7);
  const std::vector<PlanarObservation> seen = {{4, z}};

  PlanarEkf first_observation(model, Q, R);
  first_observation.reset(pose, P);
  EXPECT_EQ(first_observation.update(seen).initialised, 1);

  PlanarEkf prior(model, Q, R);
  Vector x(5);
  x << pose, place_landmark(pose, z).position;
  Matrix P_prior = Matrix::Zero(5, 5);
  P_prior.topLeftCorner<3, 3>() = P;
  constexpr double kHuge = 1e6;
  P_prior.bottomRightCorner<2, 2>() = kHuge * Eigen::Matrix2d::Identity();
  prior.reset(x, P_prior, std::vector<int>{4});
  ASSERT_TRUE(prior.update(seen).ok);

  EXPECT_LT((first_observation.state() - prior.state()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((first_observation.covariance() - prior.covariance()).cwiseAbs().maxCoeff(), 1e-6);
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

TEST(EkfSlam, ALandmarkThatIsThereTwiceIsRefused) {
  const PlanarModel model{.vehicle = {}, .dt_s = 0.1};
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  PlanarEkf filter(model, I, I);
  EXPECT_THROW(filter.reset(Vector::Zero(7), Matrix::Identity(7, 7), std::vector<int>{3, 3}),
               std::invalid_argument);
  filter.reset(Vector{{0.0, 0.0, 0.0, 1.0, 2.0}}, Matrix::Identity(5, 5), std::vector<int>{0});
  BlockMapEkfSlam<PlanarModel> block_map(model, I, I);
  for (const int number : {0, 1}) {  // known, and not known yet
    const std::vector<PlanarObservation> twice{
        {number, RangeBearing(1.0, 0.0)}, {7, RangeBearing(2.0, 0.0)}, {number, RangeBearing(1.0, 0.5)}};
    EXPECT_THROW(filter.update(twice), std::invalid_argument);
    EXPECT_THROW(block_map.update(twice), std::invalid_argument);
    EXPECT_EQ(filter.state().size(), 5);
    EXPECT_EQ(filter.covariance(), Matrix::Identity(5, 5));
  }
}

/// H of the landmarks that a filter knows, at its estimate; zero rows for the others.
Matrix jacobian_of(const PlanarEkf& filter, const std::vector<PlanarObservation>& z) {
  const Index n = filter.state().size();
  Matrix H(0, n);
  for (const PlanarObservation& o : z) {
    const Index at = filter.offset_of(o.landmark);
    if (at < 0) continue;
    const auto predicted = PlanarModel{}.predict(filter.pose(), filter.state().segment<2>(at));
    H.conservativeResize(H.rows() + 2, n);
    H.bottomRows(2).setZero();
    H.bottomRows(2).leftCols(3) = predicted.H_r;
    H.block<2, 2>(H.rows() - 2, at) = predicted.H_l;
  }
  return H;
}

TEST(EkfSlam, AnUpdateIsJosephsForm) {
  for (const int observed : {1, 3, 12}) {
    PlanarLoop loop(15, observed);
    auto filter = loop.make_filter<PlanarEkf>();
    for (int k = 0; k < 60; ++k) {
      const std::vector<PlanarObservation> z = loop.observe();
      filter.predict(loop.control());
      const Matrix P = filter.covariance(), H = jacobian_of(filter, z);
      const Vector x = filter.state();
      const Index n = x.size(), m = H.rows();
      ASSERT_TRUE(filter.update(z).ok);
      if (m == 0) continue;
      Matrix R = Matrix::Zero(m, m);
      for (Index i = 0; i < m; i += 2) R.block<2, 2>(i, i) = loop.R();
      const Matrix S = H * P * H.transpose() + R, K = P * H.transpose() * S.inverse();
      const Matrix T = Matrix::Identity(n, n) - K * H;
      const Matrix expected = T * P * T.transpose() + K * R * K.transpose();
      const Vector deviation = expected.diagonal().cwiseSqrt();
      const Matrix got = filter.covariance().topLeftCorner(n, n);
      EXPECT_LT(((got - expected).array() / (deviation * deviation.transpose()).array()).abs().maxCoeff(),
                1e-10);
      EXPECT_EQ(filter.covariance(), filter.covariance().transpose());
      EXPECT_LT((filter.gain() - K).cwiseAbs().maxCoeff(), 1e-10 * (1.0 + K.cwiseAbs().maxCoeff()));
      Vector correction = filter.state().head(n) - x;
      correction[2] = wrap_angle(correction[2]);
      EXPECT_LT((correction - K * filter.innovation()).cwiseAbs().maxCoeff(), 1e-9);
    }
    EXPECT_EQ(filter.joseph_updates(), 0);
  }
}

TEST(EkfSlam, NoBitDependsOnTheInstructionSet) {
  const auto run = [](InstructionSet set) {
    PlanarLoop loop(15, 7);
    auto filter = loop.make_filter<PlanarEkf>(InflationRule{}, std::vector<Anchor<PlanarModel>>{}, set);
    for (int k = 0; k < 50; ++k) {
      filter.predict(loop.control());
      EXPECT_TRUE(filter.update(loop.observe()).ok);
    }
    return filter;
  };
  const PlanarEkf expected = run(InstructionSet::scalar);
  for (const InstructionSet set : supported_sets()) {
    const PlanarEkf filter = run(set);
    EXPECT_EQ(filter.state(), expected.state()) << instruction_set_name(set);
    EXPECT_EQ(filter.covariance(), expected.covariance());
    EXPECT_EQ(filter.gain(), expected.gain());
  }
}

TEST(EkfSlam, StaysPositiveDefiniteOverManySteps) {
  // Small noise, so that differences of landmarks become far better known than their places.
  PlanarLoop loop(8, 2, 0.02);
  auto filter = loop.make_filter<PlanarEkf>();
  for (int k = 0; k < 100000; ++k) {
    filter.predict(loop.control());
    ASSERT_TRUE(filter.update(loop.observe()).ok) << k;
    if (k % 2000 != 1999) continue;
    const Matrix& P = filter.covariance();
    ASSERT_EQ(P, P.transpose());
    const Vector scale = P.diagonal().cwiseSqrt().cwiseInverse();
    const Matrix correlation = scale.asDiagonal() * P * scale.asDiagonal();
    ASSERT_GT(Eigen::SelfAdjointEigenSolver<Matrix>(correlation).eigenvalues().minCoeff(), 1e-6) << k;
  }
  EXPECT_EQ(filter.joseph_updates(), 0);
}

TEST(EkfSlam, AVaguePriorIsCorrectedInJosephsForm) {
  // Two landmarks with a variance of 1e8 m², 0.999999 of it in common, against measurements of 1e-7 m².
  using Scalar = MonobotModel::Scalar;
  Matrix P(3, 3);
  P << 1.0, 0.0, 0.0, 0.0, 1e8, 0.999999e8, 0.0, 0.999999e8, 1e8;
  const double r = 1e-7;
  EkfSlam<MonobotModel> filter({}, Scalar(0.0), Scalar(r));
  filter.reset(Vector::Zero(3), P, std::vector<int>{0, 1});
  const std::vector<Observation<MonobotModel>> z = {{0, Scalar(1.0)}, {1, Scalar(2.0)}};
  ASSERT_TRUE(filter.update(z).ok);
  EXPECT_EQ(filter.joseph_updates(), 1);
  // Exact to first order in 1e-8: the map follows the vehicle, whose variance stays, with independent errors.
  Matrix expected = Matrix::Ones(3, 3);
  expected(1, 1) += r;
  expected(2, 2) += r;
  const Matrix got = filter.covariance();
  EXPECT_LT((got - expected).cwiseAbs().maxCoeff(), 1e-7);
  const Eigen::Vector2d difference(1.0, -1.0);
  EXPECT_NEAR(difference.dot(got.bottomRightCorner(2, 2) * difference) / (2.0 * r), 1.0, 1e-4);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix>(got).eigenvalues().minCoeff(), 0.0);

  // The same as P − W Wᵀ has lost that difference to rounding: why there is another form.
  Matrix H(2, 3);
  H << -1.0, 1.0, 0.0, -1.0, 0.0, 1.0;
  const Matrix S = H * P * H.transpose() + r * Matrix::Identity(2, 2);
  const Eigen::LLT<Matrix> llt(S);
  const Matrix W = llt.matrixL().solve(H * P).transpose();
  const Matrix plain = P - W * W.transpose();
  EXPECT_GT(std::abs(difference.dot(plain.bottomRightCorner(2, 2) * difference) / (2.0 * r) - 1.0), 1e-2);
}

TEST(EkfSlam, AnExactMeasurementIsCorrectedInJosephsForm) {
  using Scalar = MonobotModel::Scalar;
  EkfSlam<MonobotModel> filter({}, Scalar(0.1), Scalar(0.0));
  filter.reset(Vector::Zero(3), Matrix::Identity(3, 3), std::vector<int>{0, 1});
  const std::vector<Observation<MonobotModel>> z = {{0, Scalar(1.0)}};
  ASSERT_TRUE(filter.update(z).ok);
  EXPECT_EQ(filter.joseph_updates(), 1);
  EXPECT_NEAR(filter.state()[1] - filter.state()[0], 1.0, 1e-15);
  const Matrix P = filter.covariance();
  EXPECT_NEAR(P(0, 0), 0.5, 1e-15);
  EXPECT_NEAR(P(0, 0) - 2.0 * P(0, 1) + P(1, 1), 0.0, 1e-15);
  EXPECT_EQ(P(2, 2), 1.0);
  filter.predict(Scalar(0.0));
  EXPECT_TRUE(filter.update(z).ok);
}

TEST(EkfSlam, SequentialInflationNeedsADiagonalR) {
  InflationRule rule;
  rule.inflation = Inflation::map;
  const PlanarModel model{.vehicle = {}, .dt_s = 0.1};
  const Eigen::Matrix2d Q = 0.01 * Eigen::Matrix2d::Identity();
  Eigen::Matrix2d R;
  R << 0.01, 0.001, 0.001, 0.0004;
  EXPECT_NO_THROW(PlanarEkf(model, Q, R, rule));
  rule.solution = InflationSolution::sequential;
  EXPECT_THROW(PlanarEkf(model, Q, R, rule), std::invalid_argument);
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
}  // namespace credence::internal
