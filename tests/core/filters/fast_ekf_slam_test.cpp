#include "core/filters/fast_ekf_slam.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/core/filters/golden_problem.h"

namespace credence {
namespace {

using PlanarFast = FastEkfSlam<PlanarModel>;
using PlanarObservations = std::vector<Observation<PlanarModel>>;

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

  PlanarObservations observe() {
    truth_ = model().vehicle.moved(truth_, control() + 0.1 * noise_ * noise(), 0.1);
    PlanarObservations z;
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

/// The largest difference of two covariances in units of the standard deviations.
double relative_difference(const Matrix& P, const Matrix& expected) {
  const Vector deviation = expected.diagonal().cwiseSqrt();
  return ((P - expected).array() / (deviation * deviation.transpose()).array()).abs().maxCoeff();
}

template <class Fast, class Dense>
void expect_equal(const Fast& fast, const Dense& dense, int step) {
  const Vector& x = dense.state();
  ASSERT_EQ(fast.state().size(), x.size());
  EXPECT_LT((fast.state() - x).cwiseAbs().maxCoeff(), 1e-12 * x.cwiseAbs().maxCoeff()) << step;
  EXPECT_LT(relative_difference(fast.covariance(), dense.covariance()), 1e-12) << step;
}

void expect_equal(const UpdateResult& fast, const UpdateResult& dense) {
  EXPECT_EQ(fast.ok, dense.ok);
  EXPECT_EQ(fast.dof, dense.dof);
  EXPECT_EQ(fast.initialised, dense.initialised);
  EXPECT_NEAR(fast.nis, dense.nis, 1e-10 * (1.0 + dense.nis));
  EXPECT_NEAR(fast.trace_prior, dense.trace_prior, 1e-12 * dense.trace_prior);
}

TEST(FastEkfSlam, IsTheDenseFilterStepByStep) {
  for (const int observed : {0, 1, 3, 10}) {
    for (const int flush_steps : {1, 4, 7, 16}) {
      PlanarLoop loop(15, observed);
      // Two of the landmarks are known beforehand; the others appear over time.
      const std::vector<Anchor<PlanarModel>> anchors = {{2, loop.place(2)}, {9, loop.place(9)}};
      auto dense = loop.make_filter<EkfSlam<PlanarModel>>(InflationRule{}, anchors);
      auto fast = loop.make_filter<PlanarFast>(FastEkfSlamOptions{.flush_steps = flush_steps}, anchors);
      for (int k = 0; k < 60; ++k) {
        const PlanarObservations z = loop.observe();
        dense.predict(loop.control());
        fast.predict(loop.control());
        const UpdateResult expected = dense.update(z);
        ASSERT_NO_FATAL_FAILURE(expect_equal(fast.update(z), expected));
        ASSERT_NO_FATAL_FAILURE(expect_equal(fast, dense, k));
        if (expected.dof > 0 && expected.initialised == 0) {
          EXPECT_LT((fast.innovation() - dense.innovation()).cwiseAbs().maxCoeff(), 1e-12);
          EXPECT_LT((fast.innovation_covariance() - dense.innovation_covariance()).cwiseAbs().maxCoeff(),
                    1e-12 * dense.innovation_covariance().cwiseAbs().maxCoeff());
          ASSERT_EQ(fast.gain().cols(), dense.gain().cols());
          EXPECT_LT((fast.gain() - dense.gain()).cwiseAbs().maxCoeff(),
                    1e-10 * (1.0 + dense.gain().cwiseAbs().maxCoeff()));
        }
      }
      EXPECT_EQ(fast.layout().landmarks, observed == 0 ? 0 : 13);
      EXPECT_EQ(fast.joseph_updates(), 0);
      for (int id = -1; id < 20; ++id) EXPECT_EQ(fast.offset_of(id), id < 0 ? -1 : dense.offset_of(id));
      EXPECT_TRUE(std::ranges::equal(fast.landmarks(), dense.landmarks()));
    }
  }
}

TEST(FastEkfSlam, IsTheDenseFilterOnTheMonobot) {
  using Scalar = MonobotModel::Scalar;
  for (const int observed : {1, 3, 10}) {
    for (const int flush_steps : {1, 4, 16}) {
      EkfSlam<MonobotModel> dense({}, Scalar(0.1), Scalar(0.1));
      FastEkfSlam<MonobotModel> fast({}, Scalar(0.1), Scalar(0.1), {.flush_steps = flush_steps});
      dense.reset(Scalar(-1.0), Scalar(1.0));
      fast.reset(Scalar(-1.0), Scalar(1.0));
      for (int k = 0; k < 60; ++k) {
        std::vector<Observation<MonobotModel>> z;
        for (int i = 0; i < observed; ++i)
          z.push_back({(k / 3 + i) % 12, Scalar(2.0 + std::sin(k + 3.0 * i))});
        dense.predict(Scalar(0.1));
        fast.predict(Scalar(0.1));
        const UpdateResult expected = dense.update(z);
        ASSERT_NO_FATAL_FAILURE(expect_equal(fast.update(z), expected));
        ASSERT_NO_FATAL_FAILURE(expect_equal(fast, dense, k));
      }
    }
  }
}

TEST(FastEkfSlam, HoldsTheGoldenValuesExplicitAndDelayed) {
  for (const GoldenStep& golden : kGoldenSteps) {
    for (const int flush_steps : {1, 4, 7, 16}) {  // 4 and 7: a flush within the ten steps
      GoldenProblem problem(golden.landmarks);
      auto filter = problem.make_filter<PlanarFast>(FastEkfSlamOptions{.flush_steps = flush_steps});
      for (int k = 0; k < 10; ++k) problem.step(filter, k, golden.m);
      EXPECT_NEAR(filter.state().sum() / golden.sum, 1.0, 2e-9);
      EXPECT_NEAR(filter.covariance().trace() / golden.trace, 1.0, 4e-9);
      EXPECT_NEAR(filter.covariance_trace() / golden.trace, 1.0, 4e-9);
    }
  }
}

TEST(FastEkfSlam, NoBitDependsOnTheFlushOrTheInstructionSet) {
  const auto run = [](const FastEkfSlamOptions& options) {
    PlanarLoop loop(15, 3);
    auto filter = loop.make_filter<PlanarFast>(options);
    for (int k = 0; k < 50; ++k) {
      filter.predict(loop.control());
      EXPECT_TRUE(filter.update(loop.observe()).ok);
    }
    return filter;
  };
  const PlanarFast expected = run({.flush_steps = 1, .instruction_set = InstructionSet::scalar});
  for (const InstructionSet set : supported_sets()) {
    for (const int flush_steps : {1, 4, 7, 16}) {
      const PlanarFast filter = run({flush_steps, set});
      EXPECT_EQ(filter.state(), expected.state()) << instruction_set_name(set) << " " << flush_steps;
      EXPECT_EQ(filter.covariance(), expected.covariance());
      EXPECT_EQ(filter.gain(), expected.gain());
    }
  }
}

TEST(FastEkfSlam, AnyBlockCanBeReadBetweenFlushes) {
  PlanarLoop loop(12, 2);
  auto filter = loop.make_filter<PlanarFast>(FastEkfSlamOptions{.flush_steps = 7});
  for (int k = 0; k < 40; ++k) {
    filter.predict(loop.control());
    const auto check = [&] {
      const Matrix P = filter.covariance();
      const Index n = filter.state().size();
      EXPECT_EQ(P, P.transpose());
      EXPECT_EQ(filter.covariance_block(0, 0, 3, n), P.topRows(3));
      EXPECT_EQ(filter.covariance_block(n / 2, 1, n - n / 2, n - 1), P.block(n / 2, 1, n - n / 2, n - 1));
      EXPECT_NEAR(filter.covariance_trace(), P.trace(), 1e-14 * P.trace());
    };
    check();
    ASSERT_TRUE(filter.update(loop.observe()).ok);
    check();
  }
  EXPECT_THROW(filter.covariance_block(0, 0, 1, filter.state().size() + 1), std::invalid_argument);
}

TEST(FastEkfSlam, ABatchMayBeLargerThanWhatMayWait) {
  PlanarLoop loop(40, 40);
  auto dense = loop.make_filter<EkfSlam<PlanarModel>>();
  auto fast = loop.make_filter<PlanarFast>(FastEkfSlamOptions{.flush_steps = 4});
  for (int k = 0; k < 6; ++k) {
    PlanarObservations z = loop.observe();
    if (k % 2 == 1) z.resize(3);
    dense.predict(loop.control());
    fast.predict(loop.control());
    const UpdateResult expected = dense.update(z);
    expect_equal(fast.update(z), expected);
    ASSERT_NO_FATAL_FAILURE(expect_equal(fast, dense, k));
  }
}

TEST(FastEkfSlam, AnchorsAloneCorrectAnEmptyMap) {
  const PlanarLoop loop(4, 0);
  const std::vector<Anchor<PlanarModel>> anchors = {{0, loop.place(0)}, {1, loop.place(1)}};
  auto dense = loop.make_filter<EkfSlam<PlanarModel>>(InflationRule{}, anchors);
  auto fast = loop.make_filter<PlanarFast>(FastEkfSlamOptions{}, anchors);
  const PlanarObservations z = {{0, measure_range_bearing(loop.start(), loop.place(0))},
                                {1, measure_range_bearing(loop.start(), loop.place(1))}};
  for (int k = 0; k < 20; ++k) {
    const UpdateResult expected = dense.update(z);
    expect_equal(fast.update(z), expected);
    expect_equal(fast, dense, k);
    EXPECT_TRUE(fast.update({}).ok);
    EXPECT_EQ(fast.gain().cols(), 0);
  }
  EXPECT_EQ(fast.state().size(), 3);
}

TEST(FastEkfSlam, StaysPositiveDefiniteAndTheJosephFilterOverManySteps) {
  // Small noise, so that differences of landmarks become far better known than their places.
  PlanarLoop loop(8, 2, 0.02);
  auto fast = loop.make_filter<PlanarFast>();
  auto dense = loop.make_filter<EkfSlam<PlanarModel>>();
  for (int k = 0; k < 100000; ++k) {
    const PlanarObservations z = loop.observe();
    fast.predict(loop.control());
    ASSERT_TRUE(fast.update(z).ok) << k;
    // The dense one is slow: a tenth of the way it comes along.
    if (k < 10000) {
      dense.predict(loop.control());
      ASSERT_TRUE(dense.update(z).ok) << k;
    }
    if (k % 2000 != 1999) continue;
    const Matrix P = fast.covariance();
    ASSERT_EQ(P, P.transpose());
    if (k < 10000) {
      ASSERT_LT(relative_difference(P, dense.covariance()), 1e-11) << k;
    }
    const Vector scale = P.diagonal().cwiseSqrt().cwiseInverse();
    const Matrix correlation = scale.asDiagonal() * P * scale.asDiagonal();
    const Vector eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix>(correlation).eigenvalues();
    ASSERT_GT(eigenvalues.minCoeff(), 1e-6) << k;
  }
  EXPECT_EQ(fast.joseph_updates(), 0);
}

TEST(FastEkfSlam, AVaguePriorIsCorrectedInJosephsForm) {
  // Two landmarks with a variance of 1e8 m², 0.999999 of it in common, against measurements of 1e-7 m².
  using Scalar = MonobotModel::Scalar;
  Matrix P(3, 3);
  P << 1.0, 0.0, 0.0, 0.0, 1e8, 0.999999e8, 0.0, 0.999999e8, 1e8;
  const double r = 1e-7;
  FastEkfSlam<MonobotModel> filter({}, Scalar(0.0), Scalar(r));
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

TEST(FastEkfSlam, AnExactMeasurementIsCorrectedInJosephsForm) {
  using Scalar = MonobotModel::Scalar;
  FastEkfSlam<MonobotModel> filter({}, Scalar(0.1), Scalar(0.0));
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

TEST(FastEkfSlam, AnInnovationCovarianceThatIsNotPositiveDefiniteIsDataAndChangesNothing) {
  PlanarFast filter({.vehicle = {}, .dt_s = 0.1}, Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero());
  filter.reset(Pose::Zero(), Eigen::Matrix3d::Zero());
  const PlanarObservations seen = {{0, RangeBearing(3.0, 0.1)}};
  ASSERT_TRUE(filter.update(seen).ok);
  const Vector x = filter.state();
  const Matrix P = filter.covariance();
  EXPECT_FALSE(filter.update(seen).ok);
  EXPECT_EQ(filter.state(), x);
  EXPECT_EQ(filter.covariance(), P);
  EXPECT_EQ(filter.gain().cols(), 0);
}

TEST(FastEkfSlam, WhatDoesNotMatchIsRefused) {
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  PlanarFast filter({.vehicle = {}, .dt_s = 0.1}, I, I);
  EXPECT_THROW(filter.reset(Vector::Zero(4), Matrix::Identity(4, 4), std::vector<int>{0}),
               std::invalid_argument);
  EXPECT_THROW(filter.update(PlanarObservations{{-1, RangeBearing(1.0, 0.0)}}), std::invalid_argument);
  EXPECT_THROW(PlanarFast({.vehicle = {}, .dt_s = 0.1}, I, I, {.flush_steps = 0}), std::invalid_argument);
  const std::vector<Anchor<PlanarModel>> anchors = {{-3, Point::Zero()}};
  EXPECT_THROW(PlanarFast({.vehicle = {}, .dt_s = 0.1}, I, I, {}, anchors), std::invalid_argument);
}

}  // namespace
}  // namespace credence
