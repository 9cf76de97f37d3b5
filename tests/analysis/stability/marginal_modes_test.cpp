#include "analysis/stability/marginal_modes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/analysis/stability/stability_problems.h"

namespace credence::internal {
namespace {

MarginalModes modes_of(const RiccatiProblem& problem) {
  MarginalModes modes = marginal_modes(problem.F, problem.H, problem.Qt);
  EXPECT_TRUE(modes.ok);
  return modes;
}

/// A state for each number: its eigenvalue, whether it is seen, whether noise drives it.
struct Mode {
  double eigenvalue;
  bool seen, driven;
};
RiccatiProblem diagonal_problem(const std::vector<Mode>& modes) {
  const Index n = std::ssize(modes);
  RiccatiProblem problem{Matrix::Zero(n, n), Matrix::Zero(n, n), Matrix::Zero(n, n), Matrix::Identity(n, n)};
  for (Index i = 0; i < n; ++i) {
    const Mode& mode = modes[static_cast<std::size_t>(i)];
    problem.F(i, i) = mode.eigenvalue;
    problem.H(i, i) = mode.seen ? 1.0 : 0.0;
    problem.Qt(i, i) = mode.driven ? 1.0 : 0.0;
  }
  return problem;
}

TEST(MarginalModes, OfTheMonobotAreItsCommonMotionAndTheLandmarks) {
  for (const Index landmarks : {1, 2, 5}) {
    const LinearModel model = monobot_model(landmarks, 0, 0.1, 0.1, 1.0);
    const MarginalModes modes = modes_of(testing::riccati_problem(model));
    // Nothing tells where all of it is: (1, …, 1).
    ASSERT_EQ(modes.undetectable.cols(), 1);
    const Vector common = Vector::Ones(landmarks + 1) / std::sqrt(static_cast<double>(landmarks + 1));
    EXPECT_NEAR(std::abs(modes.undetectable.col(0).dot(common)), 1.0, 1e-12);
    // No noise moves a landmark.
    EXPECT_EQ(modes.untouched.cols(), landmarks);
    EXPECT_LT(modes.untouched.row(0).norm(), 1e-12);
    EXPECT_EQ(modes.unstable_undetectable + modes.unstable_uncontrollable, 0);
    EXPECT_TRUE(modes.paired());
  }
}

TEST(MarginalModes, OfTheAnchoredMonobotAreAllSeen) {
  const LinearModel model = monobot_model(3, 1, 0.1, 0.1, 1.0);
  const MarginalModes modes = modes_of(testing::riccati_problem(model));
  EXPECT_EQ(modes.undetectable.cols(), 0);
  EXPECT_EQ(modes.undetectable.rows(), 4);
  EXPECT_TRUE(modes.paired());
}

TEST(MarginalModes, OfTheMonobotWithEverythingTouchedFixNothing) {
  RiccatiProblem problem = testing::riccati_problem(monobot_model(2, 0, 0.1, 0.1, 1.0));
  problem.Qt = Matrix::Identity(3, 3);
  const MarginalModes modes = modes_of(problem);
  EXPECT_EQ(modes.untouched.cols(), 0);
  EXPECT_EQ(modes.pairing.rank, 0);
  EXPECT_FALSE(modes.paired());
  // The map alone, its common motion left out, as in the paper's Figure 3: a Laplacian.
  problem.Qt = Matrix::Zero(3, 3);
  problem.Qt(0, 0) = 0.1;
  problem.Qt.bottomRightCorner(2, 2) << 1.0, -1.0, -1.0, 1.0;
  const MarginalModes map = modes_of(problem);
  EXPECT_EQ(map.untouched.cols(), 1);
  EXPECT_TRUE(map.paired());
}

TEST(MarginalModes, AreCountedByWhereTheyLie) {
  const MarginalModes modes = modes_of(diagonal_problem({{0.5, false, false},
                                                         {1.0, false, true},
                                                         {-1.0, false, false},
                                                         {2.0, false, true},
                                                         {-3.0, true, false},
                                                         {1.0, true, false},
                                                         {1.5, true, true}}));
  EXPECT_EQ(modes.undetectable.cols(), 3);
  EXPECT_EQ(modes.unstable_undetectable, 1);
  EXPECT_EQ(modes.untouched.cols(), 2);
  EXPECT_EQ(modes.unstable_uncontrollable, 1);
  EXPECT_EQ(modes.pairing.rank, 1);
  EXPECT_FALSE(modes.paired());
}

TEST(MarginalModes, AModeIsPairedWithWhatNoNoiseTouches) {
  EXPECT_TRUE(modes_of(diagonal_problem({{1.0, false, false}})).paired());
  EXPECT_TRUE(modes_of(diagonal_problem({{-1.0, false, false}, {0.3, true, true}})).paired());
  EXPECT_FALSE(modes_of(diagonal_problem({{1.0, false, true}})).paired());
  EXPECT_FALSE(modes_of(diagonal_problem({{2.0, false, false}})).paired()) << "unstable, and nobody sees it";
  EXPECT_TRUE(modes_of(diagonal_problem({{0.9, false, true}})).paired()) << "it forgets";
  EXPECT_TRUE(modes_of(diagonal_problem({{2.0, true, false}})).paired()) << "seen";
}

TEST(MarginalModes, OfAChainOnlyWhatStaysBoundedIsSteady) {
  // A constant velocity that nobody sees: the position grows with it.
  RiccatiProblem problem{Matrix::Identity(2, 2), Matrix::Zero(1, 2), Matrix::Zero(2, 2),
                         Matrix::Identity(1, 1)};
  problem.F(0, 1) = 1.0;
  const MarginalModes modes = modes_of(problem);
  EXPECT_EQ(modes.undetectable.cols(), 2);
  EXPECT_EQ(modes.untouched.cols(), 2);
  EXPECT_EQ(modes.pairing.rank, 1) << "the velocity";
  EXPECT_FALSE(modes.paired());
  // Its position seen, it is learnt.
  problem.H(0, 0) = 1.0;
  EXPECT_TRUE(modes_of(problem).paired());
}

TEST(MarginalModes, AreInvariant) {
  // In mixed coordinates: a rotation that nobody sees and no noise touches, and others.
  std::mt19937_64 generator(7);
  RiccatiProblem problem{Matrix::Zero(5, 5), Matrix::Zero(1, 5), Matrix::Zero(5, 5), Matrix::Identity(1, 1)};
  problem.F.topLeftCorner(2, 2) << 0.6, -0.8, 0.8, 0.6;
  problem.F.diagonal().tail(3) << 1.0, 0.4, 1.2;
  problem.H(0, 2) = problem.H(0, 4) = 1.0;
  problem.Qt(3, 3) = 1.0;
  const Matrix T = Matrix::Identity(5, 5) + 0.2 * testing::random_matrix(5, 5, generator);
  const Matrix back = T.inverse();
  problem = {T * problem.F * back, problem.H * back, T * problem.Qt * T.transpose(), problem.R};
  const MarginalModes modes = modes_of(problem);
  ASSERT_EQ(modes.undetectable.cols(), 2);
  ASSERT_EQ(modes.untouched.cols(), 3);
  EXPECT_EQ(modes.unstable_uncontrollable, 1);
  EXPECT_TRUE(modes.paired());
  const Matrix& U = modes.undetectable;
  EXPECT_LT((problem.F * U - U * (U.transpose() * problem.F * U)).norm(), 1e-9);
  EXPECT_LT((problem.H * U).norm(), 1e-9);
  const Matrix& W = modes.untouched;
  const Matrix Ft = problem.F.transpose();
  EXPECT_LT((Ft * W - W * (W.transpose() * Ft * W)).norm(), 1e-9);
  EXPECT_LT((problem.Qt * W).norm(), 1e-7);
}

TEST(PairSubspaces, CountsTheAnglesThatAreNotRight) {
  const Matrix I = Matrix::Identity(4, 4);
  EXPECT_EQ(pair_subspaces(I.leftCols(2), I.leftCols(2)).rank, 2);
  EXPECT_EQ(pair_subspaces(I.leftCols(2), I.rightCols(2)).rank, 0);
  EXPECT_EQ(pair_subspaces(I.leftCols(2), I.middleCols(1, 2)).rank, 1);
  EXPECT_EQ(pair_subspaces(Matrix(4, 0), I.leftCols(2)).rank, 0);
  for (const double cosine : {1e-3, 1e-6}) {
    const Vector tilted{{cosine, std::sqrt(1.0 - cosine * cosine), 0.0, 0.0}};
    EXPECT_EQ(pair_subspaces(tilted, I.col(0)).rank, 1) << cosine;
  }
  const Vector rounding{{1e-9, 1.0, 0.0, 0.0}};
  EXPECT_EQ(pair_subspaces(rounding, I.col(0)).rank, 0) << "the scale of a cosine is absolute";
}

}  // namespace
}  // namespace credence::internal
