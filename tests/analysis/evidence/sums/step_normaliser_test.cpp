#include "analysis/evidence/sums/step_normaliser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "core/nan.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"
#include "tests/paths.h"

namespace credence::internal {
namespace {

using Places = std::vector<Index>;

// A pose in the plane with its parts, and two landmarks.
RunLayout layout_of_plane() {
  return {.states = {"x", "y", "h", "f1x", "f1y", "f2x", "f2y"},
          .angles = {false, false, true, false, false, false, false},
          .blocks = {{"pose", Part::pose, {0, 1, 2}},
                     {"position", Part::position, {0, 1}},
                     {"heading", Part::heading, {2}},
                     {"landmark 1", Part::landmark, {3, 4}},
                     {"landmark 2", Part::landmark, {5, 6}}}};
}

RunLayout layout_of_two_blocks() {
  return {.states = {"a", "b", "c"},
          .angles = {false, false, false},
          .blocks = {{"first", Part::other, {0, 1}}, {"second", Part::other, {2}}},
          .sensors = {{.name = "", .dim = 2, .piece = 2, .variances = {1.0, 2.0}}}};
}

// eᵀ P⁻¹ e = 4/3 of the first two states, (e₁² − e₁ e₂ + e₂²)/(3/4) of (1, 1); 16/4 of the third.
Step step_of_two_blocks() {
  Step step{.step = 1, .states = {0, 1, 2}, .error = Vector{{1.0, 1.0, 4.0}}};
  step.P = Matrix{{1.0, 0.5, 0.0}, {0.5, 1.0, 0.0}, {0.0, 0.0, 4.0}};
  step.innovations.resize(1);
  return step;
}

/// With the places of the states of each step.
struct Normaliser {
  const RunLayout& layout;
  StepPlaces places = {};
  StepNormaliser normaliser = {};
  NormalisedStep result = {};

  std::string_view normalise(const Step& step) {
    places.find(step.states, layout);
    return normaliser.normalise(step, layout, places, result);
  }
};

TEST(StepPlaces, AreThoseOfTheStatesThatAStepHas) {
  const RunLayout layout = layout_of_plane();
  StepPlaces places;
  places.find({0, 1, 2, 5, 6}, layout);
  EXPECT_EQ(places.of_block, (std::vector<Places>{{0, 1, 2}, {0, 1}, {2}, {}, {3, 4}}));
  EXPECT_EQ(places.angles, Places{2});
  places.find({1, 2, 3}, layout);
  EXPECT_EQ(places.of_block, (std::vector<Places>{{0, 1}, {0}, {1}, {2}, {}}));
  EXPECT_EQ(places.angles, Places{1});
  EXPECT_EQ(position_block(layout), 1);
  EXPECT_TRUE(has_planar_map(layout));
  RunLayout blind = layout;
  blind.has_truth = false;
  EXPECT_EQ(position_block(blind), -1);
  EXPECT_FALSE(has_planar_map(blind));
  EXPECT_EQ(position_block(layout_of_two_blocks()), -1);
}

TEST(LeadBlock, IsThePoseOrThatWithMostStatesWhateverTheOrder) {
  const auto lead_of = [](const RunLayout& layout) {
    const Index lead = lead_block(layout);
    return lead < 0 ? "" : layout.blocks[static_cast<std::size_t>(lead)].name;
  };
  RunLayout plane = layout_of_plane(), two = layout_of_two_blocks();
  RunLayout equal{
      .blocks = {{"v", Part::other, {0, 1}}, {"b", Part::other, {2}}, {"p", Part::other, {3, 4}}}};
  RunLayout large{.blocks = {{"few", Part::other, {0}}, {"many", Part::other, Places(25, 1)}}};
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(lead_of(plane), "pose");
    EXPECT_EQ(lead_of(two), "first");
    EXPECT_EQ(lead_of(equal), "p");
    EXPECT_EQ(lead_of(large), "few");
    for (RunLayout* layout : {&plane, &two, &equal, &large}) std::ranges::reverse(layout->blocks);
  }
  EXPECT_EQ(lead_block({}), -1);
}

TEST(StepNormaliser, HasTheNumbersOfTheMatricesByHand) {
  const RunLayout layout = layout_of_two_blocks();
  Step step = step_of_two_blocks();
  // ν = (2, 1) of S = [4 2; 2 5], det 16: (5·4 − 2·2·2 + 4)/16 = 1; tr(S⁻¹ diag(1, 2))/2 = (5 + 8)/32.
  step.innovations[0] = {Vector{{2.0, 1.0}}, Matrix{{4.0, 2.0}, {2.0, 5.0}}};
  Normaliser of{layout};
  ASSERT_EQ(of.normalise(step), "");
  EXPECT_NEAR(of.result.whole.value, 4.0 / 3.0 + 4.0, 1e-14);
  EXPECT_EQ(of.result.whole.dof, 3);
  EXPECT_EQ(of.result.P, step.P);
  EXPECT_NEAR(of.result.log_determinant, std::log(0.75 * 4.0), 1e-14);
  ASSERT_EQ(of.result.blocks.size(), 2U);
  EXPECT_NEAR(of.result.blocks[0].value, 4.0 / 3.0, 1e-14);
  EXPECT_EQ(of.result.blocks[0].dof, 2);
  EXPECT_EQ(of.result.blocks[1].value, 4.0);
  EXPECT_EQ(of.result.blocks[1].dof, 1);
  EXPECT_EQ(of.result.lead.P, step.P.topLeftCorner(2, 2));
  EXPECT_EQ(of.result.lead.error, step.error.head(2));
  EXPECT_NEAR(of.result.innovations[0].value, 1.0, 1e-14);
  EXPECT_NEAR(of.result.innovations[0].noise_share, 13.0 / 32.0, 1e-14);
  EXPECT_EQ(of.result.variance, Vector(step.P.diagonal()));

  // tr(S⁻¹ R)/m with S⁻¹ = [5 −2; −2 4]/16: an R of the step comes before that of the layout.
  Matrix& R = step.innovations[0].R;
  R = Vector{{2.0, 0.5}}.asDiagonal();
  ASSERT_EQ(of.normalise(step), "");
  EXPECT_NEAR(of.result.innovations[0].noise_share, 12.0 / 32.0, 1e-14);
  R = Matrix{{2.0, 0.5}, {0.5, 0.5}};
  ASSERT_EQ(of.normalise(step), "");
  EXPECT_NEAR(of.result.innovations[0].noise_share, 10.0 / 32.0, 1e-14);

  // A silent sensor and a step without states leave nothing behind.
  step = {.step = 2};
  step.innovations.resize(1);
  ASSERT_EQ(of.normalise(step), "");
  EXPECT_EQ(of.result.whole.dof, -1);
  EXPECT_EQ(of.result.blocks[1].dof, -1);
  EXPECT_EQ(of.result.innovations[0].dof, -1);
  EXPECT_TRUE(std::isnan(of.result.innovations[0].noise_share));
  EXPECT_TRUE(std::isnan(of.result.log_determinant));
}

TEST(StepNormaliser, WithoutAJointCovarianceTheBlocksAddUp) {
  RunLayout layout = layout_of_two_blocks();
  layout.joint_covariance = false;
  Step step = step_of_two_blocks();
  step.P(0, 2) = step.P(2, 0) = kNaN;  // between the blocks: not known
  Normaliser of{layout};
  ASSERT_EQ(of.normalise(step), "");
  EXPECT_NEAR(of.result.whole.value, 4.0 / 3.0 + 4.0, 1e-14);
  EXPECT_EQ(of.result.whole.dof, 3);
  EXPECT_TRUE(std::isnan(of.result.log_determinant));
  // A state that is known exactly is no degree of freedom.
  step.error[2] = 0.0;
  step.P(2, 2) = 0.0;
  ASSERT_EQ(of.normalise(step), "");
  EXPECT_NEAR(of.result.whole.value, 4.0 / 3.0, 1e-14);
  EXPECT_EQ(of.result.whole.dof, 2);
  EXPECT_EQ(of.result.blocks[1].dof, 0);
}

// A step that is left out is no evidence, and a diverged filter would look right without it.
TEST(StepNormaliser, AnErrorBeyondAllSquaresIsOfTheLargestThatCanBeSquared) {
  const RunLayout layout = layout_of_two_blocks();
  Normaliser of{layout};
  for (const double error : {1e141, -1e200, 1e308}) {
    Step step = step_of_two_blocks();
    step.error[2] = error;
    step.innovations[0] = {Vector{{error}}, Matrix{{4.0}}};
    EXPECT_EQ(of.normalise(step), "") << error;
    EXPECT_GT(of.result.whole.value, 1e279) << error;
    EXPECT_TRUE(std::isfinite(of.result.whole.value)) << error;
    EXPECT_NEAR(of.result.error[2], std::copysign(1e140 * std::sqrt(step.P(2, 2)), error), 1e126) << error;
    EXPECT_NEAR(of.result.innovations[0].value, 1e280, 1e266) << error;
  }
  Step tiny = step_of_two_blocks();
  tiny.P *= 1e-310;
  EXPECT_EQ(of.normalise(tiny), "");
  EXPECT_GT(of.result.whole.value, 1e279);
  Step inside = step_of_two_blocks();
  inside.error[2] = 1e139 * std::sqrt(inside.P(2, 2));
  EXPECT_EQ(of.normalise(inside), "");
  EXPECT_EQ(of.result.error[2], inside.error[2]);
}

TEST(StepNormaliser, SaysWhyAStepCannotBeUsed) {
  const RunLayout layout = layout_of_two_blocks();
  Normaliser of{layout};
  Step step = step_of_two_blocks();
  step.P = Matrix::Ones(3, 3);  // which knows differences of states
  EXPECT_EQ(of.normalise(step), "an error where the covariance claims certainty");
  step = step_of_two_blocks();
  step.P(0, 1) = step.P(1, 0) = 2.0;
  EXPECT_NE(of.normalise(step), "");
  step = step_of_two_blocks();
  step.innovations[0] = {Vector{{1.0}}, Matrix{{-1.0}}};
  EXPECT_EQ(of.normalise(step), "S of an innovation is not positive semidefinite");
  step = step_of_two_blocks();
  step.problem = "a covariance is not symmetric";
  EXPECT_EQ(of.normalise(step), step.problem);
  EXPECT_EQ(of.normalise(step_of_two_blocks()), "");
}

// Of what is left NEES is that of the first block alone, 4/3 of 2 dof; the error itself stays for its RMSE.
TEST(StepNormaliser, AStateThatErrsWhereItIsKnownIsLeftOut) {
  RunLayout layout = layout_of_two_blocks();
  Step step = step_of_two_blocks();
  step.line = 7;
  step.innovations[0] = {Vector{{2.0, 1.0}}, Matrix{{4.0, 2.0}, {2.0, 5.0}}};
  Normaliser of{layout};
  for (const bool joint : {true, false}) {
    layout.joint_covariance = joint;
    step.P.row(2).setZero();
    step.P.col(2).setZero();
    if (!joint) step.P(0, 2) = step.P(2, 0) = kNaN;
    ASSERT_EQ(of.normalise(step), "");
    EXPECT_EQ(of.result.wrongly_certain, std::vector<Index>{2});
    EXPECT_EQ(of.result.line, 7);
    EXPECT_NEAR(of.result.whole.value, 4.0 / 3.0, 1e-14);
    EXPECT_EQ(of.result.whole.dof, 2);
    EXPECT_EQ(of.result.blocks[1].dof, 0);
    EXPECT_EQ(of.result.error, step.error);
    EXPECT_EQ(of.result.innovations[0].dof, 2);
    EXPECT_EQ(of.normaliser.factor_of_state(), nullptr);
  }
  step.P(0, 2) = step.P(2, 0) = 0.1;  // of a state without variance
  layout.joint_covariance = true;
  EXPECT_EQ(of.normalise(step), "a zero variance has a covariance");
  EXPECT_EQ(of.normalise(step_of_two_blocks()), "");
  EXPECT_TRUE(of.result.wrongly_certain.empty());
}

TEST(StepNormaliser, ANisThatIsNoneIsNotAddedUp) {
  RunLayout layout = layout_of_two_blocks();
  layout.sensors[0].nis_alone = true;
  Normaliser of{layout};
  Step step = step_of_two_blocks();
  for (const double none : {kNaN, -1.0, std::numeric_limits<double>::infinity(), 1e301}) {
    step.innovations = {nis_alone(none)};
    EXPECT_EQ(of.normalise(step), "a NIS that cannot be added up") << none;
  }
  step.innovations = {nis_alone(1e299)};
  EXPECT_EQ(of.normalise(step), "");
}

// As in a log of a vehicle that starts certain and drives along y: in x it claims a σ of 1e-18 at a place of
// 9.5, where neighbouring numbers are 2e-15 apart, and all of it correlated with y.
TEST(StepNormaliser, WhatIsBelowTheRoundingOfTheEstimateIsCertain) {
  const RunLayout layout = layout_of_two_blocks();
  Step step{.step = 1, .states = {0, 1, 2}, .error = Vector{{0.0, 0.5, 0.0}}};
  step.P = Vector{{1e-36, 1.0, 4.0}}.asDiagonal();
  step.P(0, 1) = step.P(1, 0) = 1e-18;
  Normaliser of{layout};
  EXPECT_EQ(of.normalise(step), "an error where the covariance claims certainty");
  step.estimate = Vector{{9.5, 1.0, 1.0}};
  EXPECT_EQ(of.normalise(step), "");
  EXPECT_NEAR(of.result.whole.value, 0.25, 1e-14);
  EXPECT_EQ(of.result.whole.dof, 2);
  step.error[0] = 1e-12;  // more than rounding
  EXPECT_EQ(of.normalise(step), "an error where the covariance claims certainty");
}

// The benchmark starts exactly and along y: after a step σ of x is 6e-19 at a place of 9.5, so that the
// covariances with all landmarks are rounding, too.
TEST(StepNormaliser, ARunCountsTheSameStatesAsCertain) {
  for (const char* estimator : {"ekf", "ukf"}) {
    const std::vector<std::string> overrides = {"study.steps=4",
                                                "filter.estimator=" + std::string(estimator)};
    const auto experiment =
        make_experiment(load_scenario(source_folder() / "scenarios/ukfm_slam2d.toml", overrides));
    StepPlaces places;
    StepNormaliser normaliser;
    NormalisedStep result;
    for (std::int64_t run = 0; run < 3; ++run) {
      Index least = 99;
      const RunTrace trace = experiment->trace(run);
      for (const TraceStep& step : trace.steps) {
        if (step.step == 0) continue;
        places.find(step.states, experiment->layout());
        ASSERT_EQ(normaliser.normalise(step, experiment->layout(), places, result), "")
            << estimator << ' ' << step.step;
        EXPECT_EQ(step.nees_dof, result.whole.dof) << estimator << ' ' << step.step;
        EXPECT_NEAR(step.nees, result.whole.value, 1e-6 * (1.0 + step.nees)) << estimator << ' ' << step.step;
        least = std::min(least, step.nees_dof - (std::ssize(step.states) - 3));
      }
      EXPECT_LT(least, 3) << "none was certain";
    }
  }
}

TEST(StepNormaliser, LooksAtThePoseAndEachLandmarkInItsTurn) {
  const RunLayout layout = layout_of_plane();
  Step step{.step = 2, .states = {0, 1, 2, 3, 4, 5, 6}, .error = Vector::LinSpaced(7, 1.0, 7.0)};
  step.estimate = Vector::LinSpaced(7, 11.0, 17.0);
  step.P = Vector::LinSpaced(7, 1.0, 7.0).asDiagonal();
  Normaliser of{layout};
  ASSERT_EQ(of.normalise(step), "");
  EXPECT_EQ(of.result.moving.places, (Places{0, 1, 2, 3, 4}));
  EXPECT_EQ(of.result.position.error, (Vector{{1.0, 2.0}}));
  step.step = 3;
  ASSERT_EQ(of.normalise(step), "");
  EXPECT_EQ(of.result.moving.places, (Places{0, 1, 2, 5, 6}));
  EXPECT_EQ(of.result.moving.error, (Vector{{1.0, 2.0, 3.0, 6.0, 7.0}}));
  EXPECT_EQ(of.result.moving.P.diagonal(), (Vector{{1.0, 2.0, 3.0, 6.0, 7.0}}));
  EXPECT_EQ(of.result.estimate, step.estimate);
  step.estimate.resize(0);  // no motion is known
  ASSERT_EQ(of.normalise(step), "");
  EXPECT_TRUE(of.result.moving.places.empty());
  EXPECT_EQ(of.result.estimate.size(), 0);
}

// Of an inertial filter of 21 states, six of which are estimates, these; of one of 25 estimates none.
TEST(StepNormaliser, LooksAtTheStatesWhoseEstimatesAreKnown) {
  const auto moving_of = [](Index states, Index estimates) {
    RunLayout layout;
    Step step{.step = 1, .error = Vector::LinSpaced(states, 1.0, 2.0)};
    step.estimate = Vector::Constant(states, kNaN);
    step.estimate.tail(estimates).setOnes();
    step.P = Matrix::Identity(states, states);
    for (Index i = 0; i < states; ++i) {
      layout.states.push_back("x" + std::to_string(i));
      step.states.push_back(i);
    }
    layout.angles.assign(layout.states.size(), false);
    Normaliser of{layout};
    EXPECT_EQ(of.normalise(step), "");
    EXPECT_EQ(of.result.moving.error, step.error(of.result.moving.places));
    return of.result.moving.places;
  };
  EXPECT_EQ(moving_of(21, 6), (Places{15, 16, 17, 18, 19, 20}));
  EXPECT_EQ(moving_of(24, 24).size(), 24U);
  EXPECT_TRUE(moving_of(25, 25).empty());
  EXPECT_TRUE(moving_of(3, 0).empty());
}

}  // namespace
}  // namespace credence::internal
