// Reference values of theory, section 6: monobot, Q = R = 0.1, P0 = I, after the update of step 100. They
// were computed for the theory by an independent program.

#include "core/filters/linear_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <span>
#include <vector>

namespace credence::internal {
namespace {

struct Row {
  const char* name;
  Index landmarks, anchors;
  Inflation inflation;
  double trace_prior, trace, var_r, var_f1, gain_f1;
};

void PrintTo(const Row& row, std::ostream* os) { *os << row.name; }

class ReferenceRow : public testing::TestWithParam<Row> {};

TEST_P(ReferenceRow, HoldsToTheDigitsGiven) {
  const Row& row = GetParam();
  const LinearModel model = monobot_model(row.landmarks, row.anchors, 0.1, 0.1, 1.0);
  InflationRule rule;
  rule.inflation = row.inflation;
  const auto steps = linear_filter_steps(model, rule, 100);
  ASSERT_EQ(steps.size(), 100U);
  const LinearFilterStep& last = steps.back();
  ASSERT_TRUE(last.ok);

  // The table has nine decimals: 1e-8 relative, or half a unit of its last digit where that is coarser.
  const auto expect_near = [](const char* what, double value, double expected) {
    EXPECT_NEAR(value, expected, std::max(1e-8 * expected, 0.501e-9)) << what;
  };
  expect_near("tr prior", last.P_prior.trace(), row.trace_prior);
  expect_near("tr post", last.P.trace(), row.trace);
  expect_near("var r", last.P(0, 0), row.var_r);
  expect_near("var f1", last.P(1, 1), row.var_f1);
  expect_near("K_f1", last.K(1, row.anchors), row.gain_f1);
}

INSTANTIATE_TEST_SUITE_P(Theory6, ReferenceRow,
                         testing::Values(Row{"1 partial none", 1, 0, Inflation::none, 1.236649890,
                                             1.136649890, 0.599226644, 0.537423246, 0.0},
                                         Row{"1 partial full", 1, 0, Inflation::full, 11.817165939,
                                             5.957736652, 2.979291469, 2.978445182, 0.491572936},
                                         Row{"1 anchored none", 1, 1, Inflation::none, 0.139121585,
                                             0.039096455, 0.037101323, 0.001995132, 0.009975660},
                                         Row{"1 anchored full", 1, 1, Inflation::full, 0.223606798,
                                             0.089442719, 0.044721360, 0.044721360, 0.276393202},
                                         Row{"2 partial none", 2, 0, Inflation::none, 1.179345194,
                                             1.079335114, 0.383847064, 0.347744025, 0.004995005},
                                         Row{"2 partial full", 2, 0, Inflation::full, 12.705589127,
                                             4.365422020, 1.433954337, 1.465733842, 0.651148708},
                                         Row{"2 partial map", 2, 0, Inflation::map, 1.872825161, 1.165749407,
                                             0.383847064, 0.390951171, 0.437066470}));

TEST(LinearFilter, MapOnlyWithOneLandmarkIsTheOptimalFilter) {
  const LinearModel model = monobot_model(1, 0, 0.1, 0.1, 1.0);
  InflationRule map;
  map.inflation = Inflation::map;
  const auto optimal = linear_filter_steps(model, {}, 50);
  const auto inflated = linear_filter_steps(model, map, 50);
  for (std::size_t k = 0; k < 50; ++k) EXPECT_EQ(optimal[k].P, inflated[k].P);
}

TEST(LinearFilter, SequentialRuleKeepsTheMapUncorrelatedAndTheBoundValid) {
  const LinearModel model = monobot_model(5, 0, 0.1, 0.1, 1.0);
  InflationRule rule;
  rule.inflation = Inflation::map;
  rule.solution = InflationSolution::sequential;
  const auto steps = linear_filter_steps(model, rule, 60);
  const auto optimal = linear_filter_steps(model, {}, 60);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Matrix P_ff = steps[k].P.bottomRightCorner(5, 5);
    EXPECT_TRUE(P_ff.isDiagonal(0.0));
    const Matrix gap = steps[k].P - optimal[k].P;
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix>(gap).eigenvalues().minCoeff(), -1e-12)
        << "step " << k + 1;
  }
}

TEST(LinearFilter, SequentialGainOfTheBatchReproducesScalarUpdates) {
  // With no map correlations to drop (one landmark), the sequential rule is the batch update.
  const LinearModel model = monobot_model(1, 2, 0.1, 0.3, 1.0);
  InflationRule rule;
  rule.inflation = Inflation::map;
  rule.solution = InflationSolution::sequential;
  const auto steps = linear_filter_steps(model, rule, 20);
  const auto batch = linear_filter_steps(model, {}, 20);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    EXPECT_LT((steps[k].K - batch[k].K).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((steps[k].P - batch[k].P).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(LinearFilter, AStepWithEveryMeasurementIsThatOfTheSharedFilter) {
  const LinearModel model = monobot_model(3, 1, 0.1, 0.2, 1.0);
  const std::vector<Index> all = {0, 1, 2, 3};
  for (const InflationSolution solution :
       {InflationSolution::pairwise, InflationSolution::min_trace, InflationSolution::sequential}) {
    InflationRule rule;
    rule.inflation = Inflation::map;
    rule.solution = solution;
    LinearFilter filter(model, rule);
    for (int pass = 0; pass < 2; ++pass, filter.reset()) {
      for (const LinearFilterStep& shared : linear_filter_steps(model, rule, 20)) {
        const LinearFilterStep& own = filter.step(all);
        EXPECT_EQ(own.P, shared.P);
        EXPECT_EQ(own.K, shared.K);
        EXPECT_EQ(own.S, shared.S);
      }
    }
  }
}

TEST(LinearFilter, AStepHasTheMeasurementsThatWereMade) {
  const LinearModel model = monobot_model(2, 0, 0.1, 0.2, 1.0);
  LinearFilter filter(model, {});
  const Matrix none = filter.step({}).P;
  EXPECT_EQ(none, Matrix(Vector{{1.1, 1.0, 1.0}}.asDiagonal()));
  EXPECT_EQ(filter.last().K.cols(), 0);
  EXPECT_EQ(filter.last().S.size(), 0);
  const std::vector<Index> second = {1};
  const LinearFilterStep& step = filter.step(second);
  // r and f_2 of variances 1.2 and 1, seen with variance 0.2
  EXPECT_NEAR(step.S(0, 0), 2.4, 1e-15);
  EXPECT_NEAR(step.K(0, 0), -0.5, 1e-15);
  EXPECT_EQ(step.K(1, 0), 0.0);
  EXPECT_NEAR(step.P(2, 2), 1.0 - 1.0 / 2.4, 1e-15);
}

// One measurement after the other is the update only where their noises are independent.
TEST(LinearFilter, ASequentialRuleNeedsADiagonalR) {
  LinearModel model = monobot_model(2, 0, 0.1, 0.2, 1.0);
  model.R(0, 1) = model.R(1, 0) = 0.1;
  EXPECT_THROW(
      LinearFilter(model,
                   {.inflation = Inflation::map, .solution = InflationSolution::sequential, .constant = {}}),
      std::invalid_argument);
  LinearFilter filter(model, {});
  const std::vector<Index> both = {0, 1}, second = {1};
  EXPECT_EQ(filter.step(both).P, linear_filter_steps(model, {}, 1).front().P);
  filter.reset();
  EXPECT_NEAR(filter.step(second).S(0, 0), 1.1 + 1.0 + 0.2, 1e-15);
}

TEST(LinearFilter, RepeatsTheMatricesOfAPeriod) {
  std::vector<LinearModel> period = {monobot_model(2, 0, 0.1, 0.2, 1.0), monobot_model(2, 0, 0.4, 0.1, 1.0)};
  period[1].F(0, 0) = 0.5;
  LinearFilter filter(period, {});
  const std::vector<Index> all = {0, 1};
  for (int pass = 0; pass < 2; ++pass, filter.reset()) {
    for (const LinearFilterStep& shared : linear_filter_steps(std::span(period), {}, 7)) {
      EXPECT_EQ(filter.step(all).P, shared.P);
    }
  }
  const auto alike = linear_filter_steps(period[0], {}, 2),
             other = linear_filter_steps(std::span(period), {}, 2);
  EXPECT_EQ(alike[0].P, other[0].P);
  EXPECT_NE(alike[1].P, other[1].P);
}

// What a measurement without noise leaves of a state is rounding, and no variance: a NEES of it, near 1 by
// chance, was judged in steps whose estimate is near 0.
TEST(LinearFilter, AMeasurementWithoutNoiseMakesAStateCertain) {
  LinearModel model;
  model.F = Matrix{{1.0, 0.1}, {0.0, 1.0}};
  model.G = Matrix{{0.0}, {1.0}};
  model.Q = Matrix{{0.2}};
  model.H = Matrix::Identity(2, 2);
  model.R = Matrix{{0.3, 0.0}, {0.0, 0.0}};
  model.P0 = Matrix::Identity(2, 2);
  model.layout = {.vehicle = 2, .landmark = 0, .landmarks = 0};
  for (const LinearFilterStep& step : linear_filter_steps(model, {}, 20)) {
    ASSERT_TRUE(step.ok);
    EXPECT_EQ(step.P.row(1), Matrix::Zero(1, 2));
    EXPECT_EQ(step.P.col(1), Matrix::Zero(2, 1));
    EXPECT_GT(step.P(0, 0), 0.01);
  }
}

TEST(LinearFilter, EndsAtAnInnovationCovarianceThatIsNotPositiveDefinite) {
  const auto steps = linear_filter_steps(monobot_model(1, 0, 0.0, 0.0, 0.0), {}, 10);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_FALSE(steps.front().ok);
}

TEST(LinearFilter, ImpossibleModelsAreRefused) {
  EXPECT_THROW(monobot_model(0, 0, 0.1, 0.1, 1.0), std::invalid_argument);
  EXPECT_THROW(monobot_model(-1, 2, 0.1, 0.1, 1.0), std::invalid_argument);
  EXPECT_THROW(monobot_model(1, 0, -0.1, 0.1, 1.0), std::invalid_argument);
  EXPECT_THROW(monobot_model(1, 0, 0.1, std::nan(""), 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
