// Stability of the monobot, against the reference values of theory, section 6 and the claims of section 5.

#include "analysis/stability/stability_analysis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace credence::internal {
namespace {

constexpr double kQ = 0.1, kR = 0.1;

struct ReferenceRow {
  const char* name;
  Index landmarks, anchors;
  Inflation inflation;
  Index inflation_rank, noise_rank, observability_rank;
  std::vector<double> eigenvalues;  // by falling modulus
  double trace_prior, trace, gain_f1;
  Index gain_column;  // the first landmark that is a state
};

const std::vector<ReferenceRow>& reference_rows() {
  using enum Inflation;
  static const std::vector<ReferenceRow> rows = {
      {"1 partial none", 1, 0, none, 0, 1, 1, {1, 0.381966}, 1.236649890, 1.136649890, 0, 0},
      {"1 partial full", 1, 0, full, 1, 2, 1, {1, 0.008391}, 11.817165939, 5.957736652, 0.491572936, 0},
      {"1 anchored none",
       1,
       1,
       none,
       0,
       1,
       2,
       {0.990024, 0.267949},
       0.139121585,
       0.039096455,
       0.009975660,
       1},
      {"1 anchored full",
       1,
       1,
       full,
       1,
       2,
       2,
       {0.781389, 0.218611},
       0.223606798,
       0.089442719,
       0.276393202,
       1},
      {"2 partial none",
       2,
       0,
       none,
       0,
       1,
       2,
       {1, 0.990010, 0.267949},
       1.179345194,
       1.079335114,
       0.004995005,
       0},
      {"2 partial full",
       2,
       0,
       full,
       2,
       3,
       2,
       {1, 0.023247, 0.007748},
       12.705589127,
       4.365422020,
       0.651148708,
       0},
      {"2 partial map",
       2,
       0,
       map,
       1,
       2,
       2,
       {1, 0.267949, 0.125867},
       1.872825161,
       1.165749407,
       0.437066470,
       0}};
  return rows;
}

StabilityAnalysis analyse(Index landmarks, Index anchors, Inflation inflation, Index horizon = 2000) {
  return analyse_stability(monobot_model(landmarks, anchors, kQ, kR, 1.0),
                           {inflation, InflationSolution::pairwise, {}}, 100, horizon);
}

TEST(StabilityAnalysis, ReproducesTheReferenceTable) {
  for (const ReferenceRow& row : reference_rows()) {
    SCOPED_TRACE(row.name);
    const StabilityAnalysis a = analyse(row.landmarks, row.anchors, row.inflation, 100);
    EXPECT_EQ(a.state_dim, row.landmarks + 1);
    EXPECT_EQ(a.inflation.rank, row.inflation_rank);
    EXPECT_EQ(a.noise_total.rank, row.noise_rank);
    EXPECT_EQ(a.observability.rank, row.observability_rank);
    EXPECT_EQ(a.controllability.rank, 1);  // n_r, whatever N
    EXPECT_NEAR(a.long_horizon.trace_prior.back(), row.trace_prior, 1e-9);
    EXPECT_NEAR(a.long_horizon.trace.back(), row.trace, 1e-9);
    EXPECT_NEAR(std::abs(a.K(1, row.gain_column)), row.gain_f1, 1e-9);
    ASSERT_EQ(a.closed_loop_eigenvalues.size(), a.state_dim);
    for (Index i = 0; i < a.state_dim; ++i) {
      EXPECT_NEAR(a.closed_loop_eigenvalues[i].real(), row.eigenvalues[static_cast<std::size_t>(i)], 6e-7);
      EXPECT_NEAR(a.closed_loop_eigenvalues[i].imag(), 0.0, 1e-9);
    }
    EXPECT_NEAR(a.spectral_radius, row.eigenvalues.front(), 6e-7);
  }
}

TEST(StabilityAnalysis, FullDecorrelationGrowsByQPerStep) {
  for (const Index landmarks : {1, 2}) {
    const StabilityAnalysis a = analyse(landmarks, 0, Inflation::full);
    EXPECT_FALSE(a.predicted_bounded);
    ASSERT_TRUE(a.noise_condition.has_value());
    EXPECT_FALSE(a.noise_condition->bounded());
    EXPECT_EQ(a.growth_direction, "common translation");
    EXPECT_FALSE(a.riccati.stays_bounded);
    EXPECT_EQ(a.riccati.kind, RiccatiKind::unbounded);
    EXPECT_NEAR(a.riccati.growth_exponent, 1.0, 0.01);
    EXPECT_EQ(a.long_horizon.growth.verdict, LongRun::growing);
    EXPECT_NEAR(a.long_horizon.growth.per_sample, kQ, 0.002 * kQ);
    EXPECT_GT(a.long_horizon.growth.exponent, 0.9);
    EXPECT_TRUE(a.paper_condition_holds);  // eq. (22) errs here: theory, section 5
    EXPECT_TRUE(std::isnan(a.initial_covariance_effect));
  }
}

TEST(StabilityAnalysis, MapDecorrelationIsBounded) {
  const StabilityAnalysis a = analyse(2, 0, Inflation::map);
  EXPECT_TRUE(a.predicted_bounded);
  ASSERT_TRUE(a.noise_condition.has_value());
  EXPECT_TRUE(a.noise_condition->bounded());
  EXPECT_EQ(a.growth_direction, "");
  EXPECT_GT(a.noise_condition->trace_bound(), 0.5 * a.riccati.P.trace());
  EXPECT_TRUE(a.riccati.stays_bounded);
  EXPECT_LT(a.riccati.residual, 1e-9);
  EXPECT_EQ(a.riccati.kind, RiccatiKind::depends_on_initial);
  EXPECT_TRUE(a.depends_on_initial);
  EXPECT_EQ(a.long_horizon.growth.verdict, LongRun::bounded);
  EXPECT_TRUE(a.paper_condition_holds);
  EXPECT_EQ(a.unobservable, std::vector<std::string>{"common translation"});
}

TEST(StabilityAnalysis, AnchoredIsBoundedAndForgetsItsStart) {
  for (const Inflation inflation : {Inflation::none, Inflation::full, Inflation::map}) {
    const StabilityAnalysis a = analyse(2, 1, inflation);
    EXPECT_TRUE(a.predicted_bounded);
    EXPECT_TRUE(a.riccati.stays_bounded);
    EXPECT_FALSE(a.depends_on_initial) << a.initial_covariance_effect;
    EXPECT_EQ(a.long_horizon.growth.verdict, LongRun::bounded);
    EXPECT_TRUE(a.unobservable.empty());
    EXPECT_LT(a.spectral_radius, 1.0);
  }
}

TEST(StabilityAnalysis, WithoutInflationTheLimitDependsOnTheStart) {
  const StabilityAnalysis a = analyse(4, 0, Inflation::none);
  EXPECT_FALSE(a.inflation_varies);
  EXPECT_TRUE(a.predicted_bounded);
  EXPECT_TRUE(a.depends_on_initial);
  EXPECT_EQ(a.long_horizon.growth.verdict, LongRun::bounded);
  for (Index i = 1; i < a.state_dim; ++i) EXPECT_LT(a.riccati.K.row(i).norm(), 1e-9);  // gains vanish
}

TEST(StabilityAnalysis, ConstantInflationOfTheRankOfOIsUnbounded) {
  // Theory, section 5: N = 2 partial, generic ΔP of rank 2 = rank O; eq. (22) says bounded.
  Matrix directions(3, 2);
  directions << 0.3, -0.8, 1.1, 0.4, -0.5, 0.9;
  InflationRule rule;
  rule.constant = 0.1 * directions * directions.transpose();
  const StabilityAnalysis a = analyse_stability(monobot_model(2, 0, kQ, kR, 1.0), rule, 100, 2000);
  EXPECT_FALSE(a.inflation_varies);
  EXPECT_EQ(a.inflation.rank, 2);
  EXPECT_TRUE(a.paper_condition_holds);
  EXPECT_FALSE(a.predicted_bounded);
  EXPECT_FALSE(a.riccati.stays_bounded);
  EXPECT_EQ(a.long_horizon.growth.verdict, LongRun::growing);
}

// The limit depends on P0, and P0 is what the filter predicts from.
TEST(StabilityAnalysis, TheLimitIsTheOneThatTheFilterGoesTo) {
  const StabilityAnalysis a = analyse(1, 0, Inflation::none);
  EXPECT_EQ(a.riccati.kind, RiccatiKind::depends_on_initial);
  EXPECT_NEAR(a.riccati.P.trace(), a.long_horizon.trace_prior.back(), 1e-9);
}

// P = 0 stays where nothing adds to it; any other prior of x⁺ = 1.5 x tends to that of P = 2.25 P/(1 + P).
TEST(StabilityAnalysis, FromNoUncertaintyTheLimitIsThatOfNoOtherStart) {
  LinearModel growing = monobot_model(0, 1, 0.0, 1.0, 0.0);
  growing.F = Matrix::Constant(1, 1, 1.5);
  const StabilityAnalysis a = analyse_stability(growing, {}, 50, 200, {"x"});
  EXPECT_EQ(a.riccati.P(0, 0), 0.0);
  EXPECT_NEAR(a.riccati_other.P(0, 0), 1.25, 1e-9);
  EXPECT_NEAR(a.initial_covariance_effect, 1.0, 1e-12);
  EXPECT_TRUE(a.depends_on_initial);
}

TEST(StabilityAnalysis, RefusesWhatItCannotAnalyse) {
  const LinearModel model = monobot_model(1, 0, kQ, kR, 1.0);
  EXPECT_THROW(analyse_stability(model, {}, 0, 100), std::invalid_argument);
  EXPECT_THROW(analyse_stability(model, {}, 100, 99), std::invalid_argument);
  EXPECT_THROW(analyse_stability(model, {}, 1, 3), std::invalid_argument);
  LinearModel broken = model;
  broken.Q(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(analyse_stability(broken, {}, 10, 20), std::invalid_argument);
}

// 9^k is beyond the range of double after 323 steps.
TEST(StabilityAnalysis, AFilterThatFailsIsToldUpToThere) {
  LinearModel blind = monobot_model(1, 0, kQ, kR, 1.0);
  blind.F = Vector{{1.0, 3.0}}.asDiagonal();
  blind.H = Matrix{{1.0, 0.0}};
  const StabilityAnalysis a = analyse_stability(blind, {}, 400, 500);
  const LongHorizon& h = a.long_horizon;
  EXPECT_EQ(h.growth.verdict, LongRun::failed);
  EXPECT_EQ(h.failure,
            "P leaves the range of double at step 324; P grows without bound: an unobservable "
            "direction is unstable");
  ASSERT_EQ(h.trace.size(), 323U);
  EXPECT_EQ(a.steps, 323);
  EXPECT_NEAR(h.growth.exponent, 323 / 2 * std::log2(9.0), 10.0);
  EXPECT_EQ(a.observability.rank, 1);
  EXPECT_EQ(a.riccati.kind, RiccatiKind::unbounded);
  EXPECT_TRUE(a.riccati.exponential);
  EXPECT_FALSE(a.predicted_bounded);
  EXPECT_NEAR(a.spectral_radius, 3.0, 1e-9);
  EXPECT_EQ(a.K.rows(), 2);

  // The steps that are asked for, where it fails only beyond them.
  EXPECT_EQ(analyse_stability(blind, {}, 100, 500).steps, 100);
}

TEST(StabilityAnalysis, AFilterThatFailsAtOnceHasNoGain) {
  LinearModel at_once = monobot_model(1, 0, kQ, kR, 1.0);
  at_once.P0 *= 1e300;
  at_once.F *= 1e10;
  const StabilityAnalysis a = analyse_stability(at_once, {}, 10, 20);
  EXPECT_EQ(a.steps, 0);
  EXPECT_TRUE(a.K.array().isNaN().all());
  EXPECT_TRUE(std::isnan(a.spectral_radius));
  EXPECT_EQ(a.closed_loop_eigenvalues.size(), 0);
  EXPECT_EQ(a.inflation.rank, 0);
  EXPECT_TRUE(std::isnan(a.long_horizon.growth.exponent));
  EXPECT_TRUE(a.long_horizon.trace.empty());
}

}  // namespace
}  // namespace credence::internal
