#include "analysis/stability/boundedness.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>

#include "core/models/linear_model.h"
#include "tests/analysis/stability/planar_jacobians.h"
#include "tests/analysis/stability/stability_problems.h"

namespace credence::internal {
namespace {

using testing::PlanarLoop;
using testing::random_matrix;
using testing::riccati_problem;

enum class Range { generic, map, with_vehicle, difference };

/// Orthonormal columns that span the directions allowed for ΔP.
Matrix allowed_directions(Index N, Range range, Index rank, std::mt19937_64& generator) {
  const Index n = N + 1;
  Matrix directions = random_matrix(n, rank, generator);
  if (rank == 0) return directions;
  if (range == Range::map || range == Range::difference) directions.row(0).setZero();
  if (range == Range::with_vehicle) directions.col(0) = Vector::Unit(n, 0);
  if (range == Range::difference) {
    const Eigen::RowVectorXd mean = directions.bottomRows(N).colwise().mean();
    directions.bottomRows(N).rowwise() -= mean;
  }
  return directions;
}

Index largest_rank(Index N, Range range) {
  if (range == Range::map) return N;
  return range == Range::difference ? N - 1 : N + 1;
}

struct RankCell {
  RiccatiProblem problem;
  Matrix inflation, P0;
  std::string name;
};

/// Every rank and range of ΔP for monobots of 1 to 4 landmarks, partially and fully observable.
std::vector<RankCell> rank_map_cells(unsigned seed) {
  std::mt19937_64 generator(seed);
  std::vector<RankCell> cells;
  for (Index N = 1; N <= 4; ++N) {
    for (const Index anchors : {0, 1}) {
      for (const Range range : {Range::generic, Range::map, Range::with_vehicle, Range::difference}) {
        const Index least = range == Range::with_vehicle ? 1 : 0;
        for (Index rank = least; rank <= largest_rank(N, range); ++rank) {
          const LinearModel model = monobot_model(N, anchors, 0.1, 0.1, 1.0);
          const Matrix U = allowed_directions(N, range, rank, generator);
          RankCell cell{riccati_problem(model), 0.1 * U * U.transpose(), model.P0, ""};
          cell.problem.Qt += cell.inflation;
          cell.name =
              ::testing::PrintToString(std::vector<Index>{N, anchors, static_cast<Index>(range), rank});
          cells.push_back(std::move(cell));
        }
      }
    }
  }
  return cells;
}

TEST(Boundedness, ExactConditionAgreesWithDoublingInEveryCell) {
  int cells = 0, bounded = 0, paper_wrong = 0;
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    for (const RankCell& cell : rank_map_cells(seed)) {
      const ExactBoundedness exact = exact_boundedness(cell.problem.F, cell.problem.H, cell.problem.Qt);
      const MeasuredBoundedness measured = measure_boundedness(cell.problem, cell.P0);
      const PaperBoundedness paper = paper_boundedness(cell.inflation, exact.observability.rank);
      EXPECT_EQ(exact.bounded(), measured.bounded)
          << cell.name << " " << to_string(exact.reason) << " g " << measured.growth_exponent;
      if (measured.bounded) {
        EXPECT_NEAR(measured.growth_exponent, 0.0, 1e-3) << cell.name;
        EXPECT_LE(exact.noise.rank, exact.observability.rank) << cell.name;  // necessary: theory, section 5
      } else {
        EXPECT_NEAR(riccati_growth(cell.problem, cell.P0).increment_exponent(), 1.0, 0.01) << cell.name;
      }
      ++cells;
      bounded += measured.bounded ? 1 : 0;
      paper_wrong += paper.bounded() != measured.bounded ? 1 : 0;
    }
  }
  EXPECT_GT(cells, 600);
  EXPECT_GT(bounded, cells / 4);
  EXPECT_LT(bounded, cells - cells / 10);
  EXPECT_GT(paper_wrong, 0);  // eq. (22) errs in some, below
}

TEST(Boundedness, PaperErrsWhereTheoryNamesIt) {
  // theory, section 5: N = 2 partial, generic ΔP of rank 2 = rank O.
  std::mt19937_64 generator(3);
  const LinearModel two = monobot_model(2, 0, 0.1, 0.1, 1.0);
  const Matrix U = random_matrix(3, 2, generator);
  RiccatiProblem problem = riccati_problem(two);
  problem.Qt += U * U.transpose();
  ExactBoundedness exact = exact_boundedness(problem.F, problem.H, problem.Qt);
  EXPECT_EQ(exact.observability.rank, 2);
  EXPECT_EQ(exact.noise.rank, 3);
  EXPECT_EQ(exact.reason, BoundednessReason::unpaired);
  EXPECT_TRUE(paper_boundedness(U * U.transpose(), 2).bounded());
  EXPECT_FALSE(measure_boundedness(problem, two.P0).bounded);

  // One landmark with full decorrelation, ΔP = c·[1 0; 0 1] − … of rank 1 = rank O (the paper's Fig. 2).
  const LinearModel one = monobot_model(1, 0, 0.1, 0.1, 1.0);
  Matrix laplacian(2, 2);
  laplacian << 0.5, -0.5, -0.5, 0.5;
  problem = riccati_problem(one);
  problem.Qt += laplacian;
  exact = exact_boundedness(problem.F, problem.H, problem.Qt);
  EXPECT_TRUE(paper_boundedness(laplacian, exact.observability.rank).bounded());
  EXPECT_FALSE(exact.bounded());
  EXPECT_FALSE(measure_boundedness(problem, one.P0).bounded);
}

TEST(Boundedness, MapOnlyLaplacianKeepsTheCommonMode) {
  const LinearModel model = monobot_model(3, 0, 0.1, 0.1, 1.0);
  RiccatiProblem problem = riccati_problem(model);
  problem.Qt.bottomRightCorner(3, 3) += 0.2 * (3.0 * Matrix::Identity(3, 3) - Matrix::Ones(3, 3));
  const ExactBoundedness exact = exact_boundedness(problem.F, problem.H, problem.Qt);
  EXPECT_EQ(exact.reason, BoundednessReason::paired);
  EXPECT_EQ(exact.unobserved, 1);
  EXPECT_EQ(exact.pairing.rank, 1);
  // The functional is the mean of the landmarks, the direction (1, 1, 1, 1): cosine √3/2.
  EXPECT_NEAR(exact.pairing.cosines[0], std::sqrt(0.75), 1e-12);
  EXPECT_TRUE(measure_boundedness(problem, model.P0).bounded);
}

TEST(Boundedness, AnchoredIsBoundedWhateverTheInflation) {
  const LinearModel model = monobot_model(2, 1, 0.1, 0.1, 1.0);
  const ExactBoundedness exact = exact_boundedness(model.F, model.H, Matrix::Identity(3, 3));
  EXPECT_EQ(exact.reason, BoundednessReason::nothing_unobserved);
  EXPECT_EQ(exact.unobserved, 0);
}

TEST(Boundedness, GeneralF) {
  const auto reason = [](const Matrix& F, const Matrix& H, const Matrix& Q) {
    return exact_boundedness(F, H, Q).reason;
  };
  const Matrix blind = Matrix::Zero(1, 1), quiet = Matrix::Zero(1, 1), one = Matrix::Ones(1, 1);
  EXPECT_EQ(reason(0.5 * one, blind, one), BoundednessReason::nothing_unobserved);
  EXPECT_EQ(reason(one, blind, one), BoundednessReason::unpaired);
  EXPECT_EQ(reason(one, blind, quiet), BoundednessReason::paired);
  EXPECT_EQ(reason(-one, blind, quiet), BoundednessReason::paired);
  EXPECT_EQ(reason(1.5 * one, blind, quiet), BoundednessReason::unstable);
  EXPECT_EQ(reason(1.5 * one, one, one), BoundednessReason::nothing_unobserved);
  // A noiseless velocity that is seen, and its integral that is not: no left eigenvector holds the position.
  Matrix F = Matrix::Identity(2, 2), H(1, 2);
  F(0, 1) = 1.0;
  H << 0.0, 1.0;
  EXPECT_EQ(reason(F, H, Matrix::Zero(2, 2)), BoundednessReason::unpaired);
  const RiccatiProblem problem{F, H, Matrix::Zero(2, 2), one};
  EXPECT_FALSE(measure_boundedness(problem, Matrix::Identity(2, 2)).bounded);
}

TEST(Boundedness, GrowsExponentially) {
  const RiccatiProblem problem = testing::scalar_problem(1.5, 0, 0);
  EXPECT_FALSE(measure_boundedness(problem, Matrix::Ones(1, 1)).bounded);
}

TEST(AccumulatedNoise, OfConstantNoiseGivesTheConstantCondition) {
  for (const RankCell& cell : rank_map_cells(9)) {
    AccumulatedNoise noise(cell.problem.state_dim());
    for (int k = 0; k < 3; ++k) noise.add(cell.problem.F, cell.problem.Qt);
    const ExactBoundedness along =
        exact_boundedness(noise, observability(cell.problem.F, cell.problem.H), kPsdRankTolerance);
    const ExactBoundedness constant = exact_boundedness(cell.problem.F, cell.problem.H, cell.problem.Qt);
    EXPECT_EQ(along.reason, constant.reason) << cell.name;
    EXPECT_EQ(along.noise.rank, constant.noise.rank) << cell.name;
  }
}

TEST(AccumulatedNoise, RanksThatAloneAreHarmlessAddUp) {
  // N = 3: each ΔP_k touches one difference of landmarks, together both, and yet never their mean; a ΔP_k on
  // single landmarks, each of rank one, touches them all.
  const LinearModel model = monobot_model(3, 0, 0.1, 0.1, 1.0);
  const Matrix GQG = model.G * model.Q * model.G.transpose();
  const ObservabilityAnalysis found = observability(model.F, model.H);
  AccumulatedNoise differences(4), singles(4);
  for (Index i = 0; i < 3; ++i) {
    const Vector difference = Vector::Unit(4, 1 + i) - Vector::Unit(4, 1 + (i + 1) % 3);
    differences.add(model.F, GQG + difference * difference.transpose());
    singles.add(model.F, GQG + Vector::Unit(4, 1 + i) * Vector::Unit(4, 1 + i).transpose());
  }
  EXPECT_EQ(exact_boundedness(differences, found, kPsdRankTolerance).reason, BoundednessReason::paired);
  EXPECT_EQ(exact_boundedness(differences, found, kPsdRankTolerance).noise.rank, 3);
  EXPECT_EQ(exact_boundedness(singles, found, kPsdRankTolerance).reason, BoundednessReason::unpaired);
}

TEST(AccumulatedNoise, PlanarVehicleNoiseAloneLeavesTheMapFixed) {
  // Without inflation: the three unobservable directions are held by the landmarks, which no noise touches.
  const PlanarLoop loop(3, Matrix(2, 0), 60);
  const ObservabilityAnalysis found = local_observability(loop.F, loop.H);
  AccumulatedNoise quiet(9), touched(9);
  const Matrix controls = Eigen::Vector2d(0.01, 1e-4).asDiagonal();
  for (std::size_t k = 0; k < loop.F.size(); ++k) {
    const Matrix Q = loop.G[k] * controls * loop.G[k].transpose();
    quiet.add(loop.F[k], Q);
    Matrix all = Q;
    all.bottomRightCorner(6, 6) += 1e-3 * Matrix::Identity(6, 6);
    touched.add(loop.F[k], all);
  }
  const ExactBoundedness held = exact_boundedness(quiet, found, kPsdRankTolerance);
  EXPECT_EQ(held.reason, BoundednessReason::paired);
  EXPECT_EQ(held.unobserved, 3);
  EXPECT_EQ(held.noise.rank, 3);
  EXPECT_EQ(exact_boundedness(touched, found, kPsdRankTolerance).reason, BoundednessReason::unpaired);
}

TEST(AccumulatedNoise, ASingularTransitionIsNamedAndNotInverted) {
  AccumulatedNoise noise(2);
  noise.add(Matrix::Zero(2, 2), Matrix::Identity(2, 2));
  EXPECT_FALSE(noise.ok());
  const ObservabilityAnalysis found = observability(Matrix::Identity(2, 2), Matrix::Identity(2, 2));
  EXPECT_EQ(exact_boundedness(noise, found, kPsdRankTolerance).reason, BoundednessReason::undecided);
  EXPECT_THROW(noise.add(Matrix::Zero(3, 3), Matrix::Zero(2, 2)), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
