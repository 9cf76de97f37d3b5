#include "analysis/stability/ranks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "analysis/stability/unobservable_names.h"
#include "core/models/linear_model.h"
#include "tests/analysis/stability/planar_jacobians.h"
#include "tests/analysis/stability/stability_problems.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using testing::PlanarLoop;
using testing::random_matrix;
using testing::random_psd;

/// Well-conditioned: orthogonal times scales between ½ and 2.
Matrix change_of_coordinates(Index n, std::mt19937_64& generator) {
  const Matrix Q = random_matrix(n, n, generator).householderQr().householderQ();
  std::uniform_real_distribution<double> scale(0.5, 2.0);
  Vector d(n);
  for (double& entry : d) entry = scale(generator);
  return Q * d.asDiagonal();
}

std::vector<std::string> names_of(const std::vector<NamedDirection>& directions) {
  std::vector<std::string> names;
  for (const NamedDirection& direction : directions) names.push_back(direction.name);
  return names;
}

TEST(DecideRank, CountsAboveTheToleranceAndReportsTheGap) {
  Vector values(4);
  values << 1e-12, 2.0, 1e-3, 0.0;
  const RankDecision decision = decide_rank(values, 1e-9);
  EXPECT_EQ(decision.rank, 2);
  EXPECT_DOUBLE_EQ(decision.gap, 1e9);
  EXPECT_EQ(decision.singular_values[0], 2.0);
  EXPECT_EQ(decide_rank(Vector::Zero(3)).rank, 0);
  EXPECT_EQ(decide_rank(Vector::Zero(3)).gap, std::numeric_limits<double>::infinity());
  EXPECT_EQ(decide_rank(Vector()).rank, 0);
  EXPECT_EQ(decide_rank(Vector::Ones(3)).gap, std::numeric_limits<double>::infinity());
}

TEST(DecideRank, WhereNothingCountsEverythingIsLeftOut) {
  const RankDecision decision = decide_rank(Vector{{0.5, 2.0}}, 1.0);
  EXPECT_EQ(decision.rank, 0);
  EXPECT_EQ(decision.gap, 0.0);
}

TEST(DecideRank, ANumberThatIsNoneIsRefused) {
  for (const double odd :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(decide_rank(Vector{{1.0, odd, 2.0}}), std::invalid_argument) << odd;
  }
}

TEST(PsdRank, OfEveryRankAndInAnyUnits) {
  std::mt19937_64 generator(2);
  for (Index n = 1; n <= 7; ++n) {
    for (Index rank = 0; rank <= n; ++rank) {
      const Matrix M = random_psd(n, rank, generator);
      Vector d(n);
      for (Index i = 0; i < n; ++i) d[i] = std::pow(10.0, static_cast<double>(i % 3) - 1.0);
      const Matrix rescaled = 1e-9 * (d.asDiagonal() * M * d.asDiagonal());
      EXPECT_EQ(psd_rank(M).rank, rank);
      EXPECT_EQ(psd_rank(rescaled).rank, rank);
      EXPECT_EQ(psd_range(M).cols(), rank);
      const Matrix null = psd_null_space(M);
      EXPECT_EQ(null.cols(), n - rank);
      EXPECT_LT((M * null).norm(), 1e-9 * (1.0 + M.norm()));
      EXPECT_LT((null.transpose() * null - Matrix::Identity(n - rank, n - rank)).norm(), 1e-12);
      if (rank > 0 && rank < n) {
        EXPECT_GT(psd_rank(M).gap, 1e6);
      }
    }
  }
}

TEST(Controllability, OfTheMonobotIsTheVehicleWhateverTheMap) {
  for (const Index N : {1, 2, 5, 50}) {
    const LinearModel model = monobot_model(N, 0, 0.1, 0.1, 1.0);
    const Controllability c = controllability(model.F, model.G, model.Q);
    EXPECT_EQ(c.decision.rank, 1);
    EXPECT_GT(c.decision.gap, 1e6);
    EXPECT_NEAR(std::abs(c.controllable(0, 0)), 1.0, 1e-14);
    EXPECT_EQ(c.uncontrollable.cols(), N);
  }
}

TEST(Controllability, ChainsOfIntegratorsAreReached) {
  // A chain of n integrators driven at its end: the Kalman matrix of ½ on the diagonal falls as 2⁻ⁿ.
  for (const Index n : {2, 10, 60}) {
    Matrix F = 0.5 * Matrix::Identity(n, n);
    F.diagonal(1).setOnes();
    Matrix B = Matrix::Zero(n, 1);
    B(n - 1, 0) = 1.0;
    EXPECT_EQ(controllability(F, B).decision.rank, n);
    EXPECT_EQ(controllability(F.transpose(), B).decision.rank, 1);
  }
}

TEST(Controllability, RanksOfBlockTriangularSystemsInAnyCoordinates) {
  std::mt19937_64 generator(4);
  for (int round = 0; round < 40; ++round) {
    const Index n = 2 + round % 9, reached = round % (n + 1);
    Matrix F = random_matrix(n, n, generator);
    F.bottomLeftCorner(n - reached, reached).setZero();
    Matrix B = Matrix::Zero(n, 2);
    B.topRows(reached) = random_matrix(reached, 2, generator);
    const Matrix T = change_of_coordinates(n, generator);
    const Matrix F_T = T * F * T.inverse();
    const Controllability c = controllability(F_T, T * B);
    ASSERT_EQ(c.decision.rank, reached) << "round " << round;
    EXPECT_LT((c.uncontrollable.transpose() * F_T * c.controllable).norm(), 1e-9 * F_T.norm());
    EXPECT_LT((c.uncontrollable.transpose() * T * B).norm(), 1e-10 * B.norm() + 1e-12);
  }
}

// One measurement of six states of nearly the same modes: the stairs to the last of them are so small that
// rounding grows to the size of a stair, and five more states that nobody sees seemed to be seen.
TEST(Observability, IsNotSeenThroughRoundingAtTheEndOfALongClimb) {
  std::mt19937_64 generator(18);
  Matrix modes = Matrix::Zero(11, 11);
  modes.topLeftCorner(2, 2) = Matrix{{0.7, 1.0}, {0.0, 0.7}};
  modes(2, 2) = modes(10, 10) = 0.99;
  modes.block(3, 3, 3, 3) = Matrix{{1.0, 1.0, 0.0}, {0.0, 1.0, 1.0}, {0.0, 0.0, 1.0}};
  for (const Index i : {6, 8}) modes.block(i, i, 2, 2) = Matrix{{0.8, -0.6}, {0.6, 0.8}};
  modes.block(6, 8, 2, 2).setIdentity();
  for (int round = 0; round < 20; ++round) {
    Matrix H = Matrix::Zero(1, 11);
    H.leftCols(6) = random_matrix(1, 6, generator);
    const Matrix T = Matrix::Identity(11, 11) + 0.1 * random_matrix(11, 11, generator);
    const Matrix back = T.inverse();
    const ObservabilityAnalysis seen = observability(T * modes * back, H * back);
    ASSERT_EQ(seen.decision.rank, 6) << round;
    EXPECT_GT(seen.decision.gap, 1e5) << round;
    EXPECT_FALSE(seen.decision.doubtful) << round;
    const Matrix unseen = back * seen.unobservable;
    EXPECT_LT(unseen.topRows(6).norm(), 1e-5 * unseen.norm()) << round;
  }
}

// The same of one state more than is examined mode by mode.
TEST(Observability, OfManyStatesADoubtIsTold) {
  std::mt19937_64 generator(18);
  const Index chain = 6;
  const auto doubts = [&](Index n) {
    int count = 0;
    for (int round = 0; round < 20; ++round) {
      Matrix F = Matrix::Zero(n, n), H = Matrix::Zero(1, n);
      F.topLeftCorner(2, 2) = Matrix{{0.7, 1.0}, {0.0, 0.7}};
      F(2, 2) = 0.99;
      F.block(3, 3, 3, 3) = Matrix{{1.0, 1.0, 0.0}, {0.0, 1.0, 1.0}, {0.0, 0.0, 1.0}};
      H.leftCols(chain) = random_matrix(1, chain, generator);
      const Matrix T = Matrix::Identity(n, n) + 0.1 * random_matrix(n, n, generator);
      const Matrix back = T.inverse();
      count += observability(T * F * back, H * back).decision.doubtful ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(doubts(chain + 1), 0);
  EXPECT_GT(doubts(kMostExaminedStates + 1), 0);
  const LinearModel wide = monobot_model(kMostExaminedStates, 0, 0.1, 0.1, 1.0);
  EXPECT_FALSE(observability(wide.F, wide.H).decision.doubtful) << "each by a sensor of its own";
}

TEST(Observability, OfTheMonobot) {
  for (const Index N : {1, 2, 5, 80}) {
    const LinearModel partial = monobot_model(N, 0, 0.1, 0.1, 1.0);
    const ObservabilityAnalysis one_short = observability(partial.F, partial.H);
    EXPECT_EQ(one_short.decision.rank, N);  // n − 1
    EXPECT_GT(one_short.decision.gap, 1e6);
    const auto names = name_unobservable(one_short.unobservable, partial.layout);
    EXPECT_THAT(names_of(names), ElementsAre("common translation"));

    const LinearModel anchored = monobot_model(N, 1, 0.1, 0.1, 1.0);
    const ObservabilityAnalysis all = observability(anchored.F, anchored.H);
    EXPECT_EQ(all.decision.rank, N + 1);
    EXPECT_TRUE(name_unobservable(all.unobservable, anchored.layout).empty());
  }
}

TEST(Observability, IsTheDualOfControllabilityAndKnowsItsDirections) {
  std::mt19937_64 generator(12);
  for (int round = 0; round < 40; ++round) {
    const Index n = 2 + round % 9, seen = round % (n + 1);
    Matrix F = random_matrix(n, n, generator);
    F.topRightCorner(seen, n - seen).setZero();
    Matrix H = Matrix::Zero(2, n);
    H.leftCols(seen) = random_matrix(2, seen, generator);
    const Matrix T = change_of_coordinates(n, generator);
    const Matrix F_T = T * F * T.inverse(), H_T = H * T.inverse();
    const ObservabilityAnalysis o = observability(F_T, H_T);
    ASSERT_EQ(o.decision.rank, seen) << "round " << round;
    EXPECT_LT((H_T * o.unobservable).norm() + (H_T * F_T * o.unobservable).norm(), 1e-9 * (1.0 + F_T.norm()));
    // Along a trajectory of n constant steps the answer is the same.
    const std::vector<Matrix> Fs(static_cast<std::size_t>(n - 1), F_T), Hs(static_cast<std::size_t>(n), H_T);
    EXPECT_EQ(local_observability(Fs, Hs).decision.rank, seen) << "round " << round;
  }
}

TEST(Observability, UnitsOfStatesAndSensorsDoNotMatter) {
  const LinearModel model = monobot_model(3, 0, 0.1, 0.1, 1.0);
  const Vector states = (Vector(4) << 1e3, 1.0, 1e-3, 10.0).finished();
  const Vector sensors = (Vector(3) << 1e-3, 1.0, 1e2).finished();
  const Matrix H = sensors.asDiagonal() * model.H * states.asDiagonal();
  const ObservabilityAnalysis o = observability(model.F, H);
  EXPECT_EQ(o.decision.rank, 3);
  EXPECT_GT(o.decision.gap, 1e4);
  EXPECT_LT((H * o.unobservable).norm(), 1e-9 * H.norm());
}

Matrix anchors_at(std::initializer_list<Eigen::Vector2d> points) {
  Matrix anchors(2, static_cast<Index>(points.size()));
  Index i = 0;
  for (const Eigen::Vector2d& point : points) anchors.col(i++) = point;
  return anchors;
}

// theory, section 5, first three rows of the planar table.
TEST(LocalObservability, OfThePlaneAtTheTruth) {
  for (const Index N : {1, 2, 6}) {
    const Index n = 3 + 2 * N;
    const PlanarLoop partial(N, Matrix(2, 0), 60);
    const ObservabilityAnalysis none = local_observability(partial.F, partial.H);
    EXPECT_EQ(none.decision.rank, n - 3);
    EXPECT_GT(none.decision.gap, 1e6);
    EXPECT_THAT(names_of(name_unobservable(none.unobservable, partial.layout, partial.start)),
                ElementsAre("common translation x", "common translation y", "rotation about the origin"));

    const Matrix one = anchors_at({{2.0, 3.0}});
    const PlanarLoop anchored(N, one, 60);
    const ObservabilityAnalysis rotation = local_observability(anchored.F, anchored.H);
    EXPECT_EQ(rotation.decision.rank, n - 1);
    EXPECT_THAT(names_of(name_unobservable(rotation.unobservable, anchored.layout, anchored.start, one)),
                ElementsAre("rotation about the anchor (2, 3)"));
    EXPECT_THAT(names_of(name_unobservable(rotation.unobservable, anchored.layout, anchored.start)),
                ElementsAre("rotation about the point (2, 3)"));

    const PlanarLoop fixed(N, anchors_at({{2.0, 3.0}, {-4.0, 1.0}}), 60);
    EXPECT_EQ(local_observability(fixed.F, fixed.H).decision.rank, n);
  }
}

TEST(LocalObservability, OfThePlaneAtAnEkfsEstimatesGainsSpuriousInformation) {
  const Index N = 4, n = 3 + 2 * N;
  const PlanarLoop partial(N, Matrix(2, 0), 60, 0.01);
  const ObservabilityAnalysis two = local_observability(partial.F, partial.H);
  EXPECT_EQ(two.decision.rank, n - 2);
  EXPECT_THAT(names_of(name_unobservable(two.unobservable, partial.layout, partial.start)),
              ElementsAre("common translation x", "common translation y"));
  const PlanarLoop anchored(N, anchors_at({{2.0, 3.0}}), 60, 0.01);
  EXPECT_EQ(local_observability(anchored.F, anchored.H).decision.rank, n);
}

TEST(LocalObservability, IsInvariantUnderAChangeOfCoordinates) {
  std::mt19937_64 generator(14);
  const PlanarLoop loop(3, Matrix(2, 0), 40);
  for (int round = 0; round < 5; ++round) {
    const Matrix T = change_of_coordinates(9, generator);
    const Matrix T_inverse = T.inverse();
    std::vector<Matrix> F, H;
    for (std::size_t k = 0; k < loop.F.size(); ++k) {
      F.push_back(T * loop.F[k] * T_inverse);
      H.push_back(loop.H[k] * T_inverse);
    }
    EXPECT_EQ(local_observability(F, H).decision.rank, 6);
  }
}

TEST(LocalObservability, StepsThatSawNothing) {
  const std::vector<Matrix> F(3, Matrix::Identity(2, 2));
  std::vector<Matrix> H(4, Matrix(0, 2));
  EXPECT_EQ(local_observability(F, H).decision.rank, 0);
  EXPECT_EQ(local_observability(F, H).unobservable.cols(), 2);
  H[2] = Matrix::Identity(1, 2);
  EXPECT_EQ(local_observability(F, H).decision.rank, 1);
}

TEST(UnobservableNames, WhatIsNoSymmetryIsListed) {
  const BlockLayout layout{.vehicle = 1, .landmark = 1, .landmarks = 2};
  Matrix direction(3, 1);
  direction << 0.0, 1.0, -1.0;
  direction /= std::sqrt(2.0);
  EXPECT_THAT(names_of(name_unobservable(direction, layout)), ElementsAre("0.71 f1, -0.71 f2"));
  // All three states unobserved: the symmetry is named first, the rest are listed.
  const auto all = name_unobservable(Matrix::Identity(3, 3), layout);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].name, "common translation");
}

TEST(UnobservableNames, ObliqueTranslationsAndUnknownLayouts) {
  const BlockLayout plane{.vehicle = 3, .landmark = 2, .landmarks = 1};
  Matrix direction(5, 1);
  direction << 0.6, 0.8, 0.0, 0.6, 0.8;
  direction /= direction.norm();
  EXPECT_THAT(names_of(name_unobservable(direction, plane)),
              ElementsAre("common translation along (0.6, 0.8)"));
  const BlockLayout other{.vehicle = 4, .landmark = 0, .landmarks = 0};
  EXPECT_THAT(names_of(name_unobservable(Matrix::Identity(4, 1), other)), ElementsAre("1.00 x1"));
}

TEST(RanksInput, BadInputIsNamed) {
  const Matrix I = Matrix::Identity(2, 2);
  EXPECT_THROW(controllability(Matrix(2, 3), I), std::invalid_argument);
  EXPECT_THROW(controllability(I, Matrix::Zero(3, 1)), std::invalid_argument);
  EXPECT_THROW(observability(I, Matrix::Zero(1, 3)), std::invalid_argument);
  EXPECT_THROW(observability(I * std::nan(""), I), std::invalid_argument);
  EXPECT_THROW(psd_rank(Matrix::Zero(2, 3)), std::invalid_argument);
  EXPECT_THROW(local_observability({}, {}), std::invalid_argument);
  EXPECT_THROW(name_unobservable(I, BlockLayout{}), std::invalid_argument);
}

TEST(Ranks, OfMatricesOfZeros) {
  const Matrix Z = Matrix::Zero(3, 3);
  EXPECT_EQ(controllability(Z, Z).decision.rank, 0);
  EXPECT_EQ(controllability(Z, Z).uncontrollable.cols(), 3);
  EXPECT_EQ(observability(Z, Z).unobservable.cols(), 3);
  EXPECT_EQ(observability(Matrix::Identity(3, 3), Matrix(0, 3)).unobservable.cols(), 3);
  EXPECT_EQ(psd_rank(Z).rank, 0);
}

}  // namespace
}  // namespace credence::internal
