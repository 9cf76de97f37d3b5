#include "core/inflation/rank_inflation.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace credence::internal {
namespace {

constexpr BlockLayout kRankMonobot{.vehicle = 1, .landmark = 1, .landmarks = 4};
constexpr BlockLayout kRankPlanar{.vehicle = 3, .landmark = 2, .landmarks = 4};
constexpr InflationRange kRanges[] = {InflationRange::generic, InflationRange::map,
                                      InflationRange::with_vehicle, InflationRange::difference};

Matrix vehicle_noise(const BlockLayout& layout) {
  Matrix G = Matrix::Zero(layout.state_dim(), layout.vehicle > 1 ? 2 : 1);
  G(0, 0) = 0.8;
  if (layout.vehicle > 1) {
    G(1, 0) = 0.6;
    G(2, 1) = 0.1;
  }
  return G;
}

Matrix common_translation(const BlockLayout& layout) {
  Matrix T = Matrix::Zero(layout.state_dim(), layout.landmark);
  for (Index i = 0; i < layout.landmarks; ++i) {
    T.middleRows(layout.landmark_offset(i), layout.landmark).setIdentity();
  }
  return T;
}

TEST(RankInflation, HasTheRankTheScaleAndTheRangeAskedFor) {
  for (const BlockLayout& layout : {kRankMonobot, kRankPlanar}) {
    const Matrix G = vehicle_noise(layout);
    const Index n = layout.state_dim();
    for (InflationRange range : kRanges) {
      for (Index rank = 0; rank <= max_inflation_rank(layout, range); ++rank) {
        if (range == InflationRange::with_vehicle && rank > 0 && rank < G.cols()) continue;
        const Matrix delta = rank_inflation(layout, G, {rank, range, 0.3, 5});
        const Vector spectrum = Eigen::SelfAdjointEigenSolver<Matrix>(delta).eigenvalues();
        // A projector times the scale: rank eigenvalues 0.3, the others 0.
        EXPECT_LT(spectrum.head(n - rank).cwiseAbs().sum(), 1e-14);
        EXPECT_LT((spectrum.tail(rank).array() - 0.3).abs().sum(), 1e-13);
        EXPECT_TRUE(delta == delta.transpose());
        if (range == InflationRange::map || range == InflationRange::difference) {
          EXPECT_TRUE(delta.topRows(layout.vehicle).isZero(0.0));
        }
        if (range == InflationRange::difference) {
          EXPECT_LT((delta * common_translation(layout)).cwiseAbs().maxCoeff(), 1e-14);
        }
        if (range == InflationRange::with_vehicle && rank > 0) {
          EXPECT_LT((delta * G - 0.3 * G).cwiseAbs().maxCoeff(), 1e-14);
        }
      }
    }
  }
}

TEST(RankInflation, GenericTouchesEverything) {
  const Matrix delta =
      rank_inflation(kRankPlanar, vehicle_noise(kRankPlanar), {1, InflationRange::generic, 1.0, 2});
  EXPECT_GT(delta.diagonal().minCoeff(), 0.0);
  EXPECT_GT((delta * common_translation(kRankPlanar)).norm(), 1e-3);
}

TEST(RankInflation, IsAFunctionOfTheSeed) {
  const Matrix G = vehicle_noise(kRankPlanar);
  const RankInflation spec{3, InflationRange::map, 1.0, 42};
  EXPECT_TRUE(rank_inflation(kRankPlanar, G, spec) == rank_inflation(kRankPlanar, G, spec));
  RankInflation other = spec;
  other.seed = 43;
  EXPECT_GT((rank_inflation(kRankPlanar, G, spec) - rank_inflation(kRankPlanar, G, other)).norm(), 0.1);
}

TEST(RankInflation, ALowerRankLiesWithinAHigherOne) {
  const Matrix G = vehicle_noise(kRankPlanar);
  for (InflationRange range : kRanges) {
    const Matrix low = rank_inflation(kRankPlanar, G, {3, range, 1.0, 7});
    const Matrix high = rank_inflation(kRankPlanar, G, {5, range, 1.0, 7});
    EXPECT_LT((high * low - low).norm(), 1e-13);
  }
}

TEST(RankInflation, MaximalRanks) {
  EXPECT_EQ(max_inflation_rank(kRankPlanar, InflationRange::generic), 11);
  EXPECT_EQ(max_inflation_rank(kRankPlanar, InflationRange::map), 8);
  EXPECT_EQ(max_inflation_rank(kRankPlanar, InflationRange::with_vehicle), 11);
  EXPECT_EQ(max_inflation_rank(kRankPlanar, InflationRange::difference), 6);
  EXPECT_EQ(max_inflation_rank({.vehicle = 3, .landmark = 2, .landmarks = 0}, InflationRange::difference), 0);
}

TEST(RankInflation, ADependentGIsContainedToo) {
  Matrix G = Matrix::Zero(5, 2);
  G.row(0) << 1.0, 2.0;
  const Matrix delta = rank_inflation(kRankMonobot, G, {1, InflationRange::with_vehicle, 2.0, 1});
  EXPECT_NEAR(delta(0, 0), 2.0, 1e-14);
  EXPECT_NEAR(delta.trace(), 2.0, 1e-14);
}

TEST(RankInflation, RejectsWhatDoesNotFit) {
  const Matrix G = vehicle_noise(kRankPlanar);
  EXPECT_THROW(rank_inflation(kRankPlanar, G, {-1}), std::invalid_argument);
  EXPECT_THROW(rank_inflation(kRankPlanar, G, {12}), std::invalid_argument);
  EXPECT_THROW(rank_inflation(kRankPlanar, G, {9, InflationRange::map}), std::invalid_argument);
  EXPECT_THROW(rank_inflation(kRankPlanar, G, {7, InflationRange::difference}), std::invalid_argument);
  EXPECT_THROW(rank_inflation(kRankPlanar, G, {1, InflationRange::with_vehicle}), std::invalid_argument);
  EXPECT_THROW(rank_inflation(kRankPlanar, G.topRows(4), {3, InflationRange::with_vehicle}),
               std::invalid_argument);
  EXPECT_THROW(rank_inflation(kRankPlanar, G, {1, InflationRange::generic, -1.0}), std::invalid_argument);
  EXPECT_THROW(
      rank_inflation(kRankPlanar, G, {1, InflationRange::generic, std::numeric_limits<double>::infinity()}),
      std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
