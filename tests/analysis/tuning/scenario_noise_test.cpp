#include "analysis/tuning/scenario_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

// A position and a velocity whose filter believes in other noise than the world has.
Scenario scenario_of_two_states(const std::string& more = "") {
  return load_scenario_text(R"(
[world]
model = "linear"
F = [[1, 1], [0, 1]]
H = [[1, 0]]
Q = [[0.2, 0.05], [0.05, 0.1]]
R = [[1]]
P0 = [[1, 0], [0, 1]]
[filter]
Q = [[0.3, 0.1], [0.1, 0.2]]
R = [[0.5]]
process_scale = 2.0
[study]
runs = 5
steps = 30
)" + more,
                            "two states");
}

UnitScores scores_at(const ScenarioScore& score, const Vector& phi) {
  return score.model().scores(phi, false);
}

std::string refusal_of(const Scenario& scenario, const char* free) {
  try {
    make_scenario_score(scenario, parse_free_noise(free), 1);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing thrown";
}

// The way back: a filter with the keys of φ scores what the score says at φ.
TEST(ScenarioNoise, TheScenarioAtAPointHasTheScoreOfThePoint) {
  const Scenario scenario = scenario_of_two_states();
  const struct {
    const char* free;
    Vector step;
  } cases[] = {{"Q,R", Vector{{0.7, -0.4}}},
               {"Q,R,P0", Vector{{0.7, -0.4, 0.5}}},
               {"full(Q),diag(R)", Vector{{0.3, -0.2, 0.4, 0.6}}},
               {"full(P0)", Vector{{0.3, -0.2, 0.4}}}};
  for (const auto& [free, step] : cases) {
    const auto score = make_scenario_score(scenario, parse_free_noise(free), 1);
    EXPECT_EQ(score->engine(), "linear filter, exact gradient");
    const Vector phi = score->start() + step;
    const UnitScores wanted = scores_at(*score, phi);
    ASSERT_TRUE(wanted.ok) << free;
    EXPECT_EQ(wanted.steps, 5.0 * 30.0) << free;
    const auto tuned = make_scenario_score(score->scenario_at(phi), parse_free_noise(free), 1);
    const UnitScores got = scores_at(*tuned, tuned->start());
    EXPECT_LT((got.value - wanted.value).cwiseAbs().maxCoeff(), 1e-9) << free;
    EXPECT_LT((got.nis - wanted.nis).cwiseAbs().maxCoeff(), 1e-9) << free;
    EXPECT_GT((wanted.value - scores_at(*score, score->start()).value).norm(), 0.1) << free;
  }
}

TEST(ScenarioNoise, FactorsBecomeScalesAndMatricesKeys) {
  const Scenario scenario = scenario_of_two_states();
  const auto factors = make_scenario_score(scenario, parse_free_noise("Q,R"), 1);
  EXPECT_EQ(factors->start(), Vector::Zero(2));
  const Scenario tuned = factors->scenario_at(Vector{{std::log(3.0), std::log(0.25)}});
  EXPECT_NEAR(tuned.filter.process_scale, 6.0, 1e-12);
  EXPECT_NEAR(tuned.filter.measurement_scale, 0.25, 1e-12);
  EXPECT_EQ(factors->key("Q").name, "filter.process_scale");
  EXPECT_EQ(factors->key("Q").unit, 2.0);
  EXPECT_EQ(factors->key("R").name, "filter.measurement_scale");
  EXPECT_EQ(factors->key("R").unit, 1.0);
  EXPECT_EQ(factors->key("P0").name, "factor of filter.P0");
  EXPECT_EQ(factors->key("R[1,1]").name, "filter.R[1,1]");
  EXPECT_EQ(factors->key("R[1,1]").unit, 1.0);
  EXPECT_EQ(factors->key("Q[2,1]").unit, 0.5) << "before filter.process_scale";
  EXPECT_EQ(factors->key("L_Q[2,1]").name, "L_Q[2,1]");
  // A matrix of its own leaves the scale as it is.
  const auto full = make_scenario_score(scenario, parse_free_noise("full(Q)"), 1);
  EXPECT_EQ(full->model().parameters(), 3);
  EXPECT_EQ(full->scenario_at(full->start() + Vector::Ones(3)).filter.process_scale, 2.0);
}

TEST(ScenarioNoise, AFilterThatMissesMeasurementsIsABlackBox) {
  const Scenario scenario = scenario_of_two_states("[noise]\ndetection_probability = 0.7\n");
  const auto score = make_scenario_score(scenario, parse_free_noise("R,Q"), 1);
  EXPECT_EQ(score->engine(), "filter as a black box, common random numbers");
  EXPECT_EQ(score->start(), Vector::Zero(2));
  EXPECT_EQ(score->model().names(), (std::vector<std::string>{"R", "Q"}));
  const Vector phi{{std::log(0.25), std::log(3.0)}};
  const Scenario tuned = score->scenario_at(phi);
  EXPECT_NEAR(tuned.filter.process_scale, 6.0, 1e-12);
  EXPECT_NEAR(tuned.filter.measurement_scale, 0.25, 1e-12);
  EXPECT_EQ(score->key("Q").unit, 2.0);
  const auto there = make_scenario_score(tuned, parse_free_noise("R,Q"), 1);
  const UnitScores wanted = scores_at(*score, phi), got = scores_at(*there, Vector::Zero(2));
  ASSERT_TRUE(wanted.ok && got.ok);
  EXPECT_LT((got.value - wanted.value).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(wanted.steps, 5.0 * 30.0);  // some are missed
}

TEST(ScenarioNoise, WhatCannotBeTunedIsNamed) {
  const std::string box =
      ": of a filter that inflates, misses measurements or is not linear only the factors Q and R can be "
      "tuned";
  const Scenario missing = scenario_of_two_states("[noise]\ndetection_probability = 0.7\n");
  EXPECT_EQ(refusal_of(missing, "P0"), "P0" + box);
  EXPECT_EQ(refusal_of(missing, "R,diag(Q)"), "Q" + box);
  const Scenario planar = load_scenario_text("[world]\nmodel = \"planar\"\n", "planar");
  EXPECT_EQ(refusal_of(planar, "full(R)"),
            "world.model = \"planar\" has no filter.R: only the factors Q and R can be tuned there");
  Scenario large = scenario_of_two_states();
  large.study.runs = 100'000;
  large.study.steps = 2001;  // times one number a step is just beyond kMostDoubles
  EXPECT_EQ(
      refusal_of(large, "Q"),
      "study.runs = 100000 and study.steps = 2001 are more measurements than are kept; fewer runs say as "
      "much");
}

}  // namespace
}  // namespace credence::internal
