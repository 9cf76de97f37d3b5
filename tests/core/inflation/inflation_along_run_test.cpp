#include "core/inflation/inflation_along_run.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

namespace credence::internal {
namespace {

constexpr BlockLayout kLayout{.vehicle = 1, .landmark = 2, .landmarks = 4};

double trace_of_map(const Matrix& P) { return P.diagonal().tail(8).sum(); }

InflationRule rule_of(Inflation inflation, InflationSolution solution) {
  return {.inflation = inflation, .solution = solution, .constant = {}};
}

/// P after measurements of rank two in a random direction.
void update(Matrix& P, std::mt19937_64& bits) {
  std::normal_distribution<double> normal;
  Matrix H(2, P.rows());
  for (double& entry : H.reshaped()) entry = normal(bits);
  const Matrix PHt = P * H.transpose();
  const Matrix S = H * PHt + Matrix::Identity(2, 2);
  P -= PHt * S.inverse() * PHt.transpose();
  P = (0.5 * (P + P.transpose())).eval();
  P(0, 0) += 0.1;
}

struct Followed {
  int rises = 0, kept = 0;
  bool feasible = true;  ///< every inflated P ⪰ the one before
};

/// 400 steps; a guarded run against the bare solver. Both stop short of the optimum.
Followed follow(bool guarded, const InflationRule& rule) {
  const MinTraceOptions early{.relative_gap = 0.5, .max_sweeps = 1, .max_interior_point_dim = 0};
  std::mt19937_64 bits(11);
  Matrix P = Matrix::Identity(9, 9);
  InflationAlongRun along;
  MinTraceState bare;
  Followed f;
  along.apply(P, kLayout, rule, early);  // block diagonal already: remembered
  double last = trace_of_map(P);
  for (int k = 0; k < 400; ++k) {
    update(P, bits);
    const Matrix before = P;
    const InflationStep step = guarded ? along.apply(P, kLayout, rule, early)
                                       : inflate(P, kLayout, rule.inflation, rule.solution, bare, early);
    const Matrix delta = P - before;
    EXPECT_NEAR(step.added_trace, delta.trace(), 1e-12 * P.trace());
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(delta, Eigen::EigenvaluesOnly);
    f.feasible = f.feasible && eigen.eigenvalues()[0] > -1e-12 * P.trace();
    f.rises += trace_of_map(P) > last ? 1 : 0;
    f.kept += step.kept ? 1 : 0;
    last = trace_of_map(P);
  }
  return f;
}

TEST(InflationAlongRun, KeepsTheBlocksWhereASolverThatStopsShortWouldRaiseThem) {
  const InflationRule rule = rule_of(Inflation::map, InflationSolution::min_trace);
  const Followed bare = follow(false, rule), guarded = follow(true, rule);
  EXPECT_GT(bare.rises, 5);
  EXPECT_EQ(bare.kept, 0);
  EXPECT_EQ(guarded.rises, 0);
  EXPECT_GT(guarded.kept, 5);
  EXPECT_TRUE(guarded.feasible);
}

TEST(InflationAlongRun, LeavesThePairwiseSumAndFullDecorrelationAlone) {
  for (const InflationRule& rule : {rule_of(Inflation::map, InflationSolution::pairwise),
                                    rule_of(Inflation::full, InflationSolution::min_trace)}) {
    const Followed guarded = follow(true, rule);
    EXPECT_EQ(guarded.kept, 0);
    EXPECT_EQ(guarded.rises, follow(false, rule).rises);
    EXPECT_GT(guarded.rises, 100);
  }
}

TEST(InflationAlongRun, AllowsARiseForANewLandmarkAndAfterAReset) {
  const InflationRule rule = rule_of(Inflation::map, InflationSolution::min_trace);
  InflationAlongRun along;
  Matrix P = Matrix::Identity(9, 9);
  along.apply(P, kLayout, rule);
  Matrix larger = Matrix::Identity(11, 11);
  const BlockLayout five{.vehicle = 1, .landmark = 2, .landmarks = 5};
  EXPECT_FALSE(along.apply(larger, five, rule).kept);
  EXPECT_EQ(larger, Matrix::Identity(11, 11));
  along.reset();
  Matrix other = 2.0 * Matrix::Identity(11, 11);
  EXPECT_FALSE(along.apply(other, five, rule).kept);
  EXPECT_EQ(other, 2.0 * Matrix::Identity(11, 11));
  // Without the reset it is no P that updates could have made, and the smaller D is kept.
  Matrix impossible = 3.0 * Matrix::Identity(11, 11);
  EXPECT_TRUE(along.apply(impossible, five, rule).kept);
}

}  // namespace
}  // namespace credence::internal
