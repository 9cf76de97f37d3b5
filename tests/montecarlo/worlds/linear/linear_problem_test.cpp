#include "montecarlo/worlds/linear/linear_problem.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

Scenario line_scenario(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"monobot\"\n", "t.toml", overrides);
}

// The doubles of what a LinearExperiment holds: models of truth and filter, and the filter's steps.
TEST(LinearProblemDoubles, AreThoseThatTheExperimentKeeps) {
  const Scenario scenario = line_scenario({"world.landmarks=3", "study.steps=7"});
  const auto experiment = make_experiment(scenario);
  const auto& linear = dynamic_cast<const LinearExperiment&>(*experiment);
  double doubles = 0.0;
  for (const std::vector<LinearModel>* models : {&linear.true_models(), &linear.assumed_models()}) {
    for (const LinearModel& model : *models) {
      doubles += static_cast<double>(model.F.size() + model.P0.size() + model.H.size() + model.R.size());
    }
  }
  ASSERT_EQ(linear.filter_steps().size(), 7U);
  for (const LinearFilterStep& step : linear.filter_steps()) {
    // P before and after, ΔP, K and S; of ΔP nothing is kept where there is none.
    doubles += static_cast<double>(3 * step.P.size() + step.K.size() + step.S.size());
  }
  EXPECT_EQ(linear_problem_doubles(4.0, 3.0, scenario), doubles);
}

// Of runs that have steps of their own none is kept: so many as there are steps must not be asked for.
TEST(LinearProblemDoubles, DoNotGrowWithTheStepsWhereEveryRunHasItsOwn) {
  for (const char* own : {"noise.detection_probability=0.9", "noise.measurement_delay=1",
                          "noise.outlier_rate=0.1", "noise.student_dof=5", "noise.process_correlation=0.5"}) {
    const std::vector<std::string> overrides = {"world.landmarks=5", own};
    std::vector<std::string> longer = overrides;
    longer.emplace_back("study.steps=1000000");
    EXPECT_EQ(linear_problem_doubles(6.0, 5.0, line_scenario(longer)),
              linear_problem_doubles(6.0, 5.0, line_scenario(overrides)))
        << own;
    const auto experiment = make_experiment(line_scenario(overrides));
    EXPECT_EQ(dynamic_cast<const LinearExperiment*>(experiment.get()), nullptr) << own;
  }
}

// 0.4 MB of dense P for each of 10 million steps.
TEST(LinearProblemDoubles, AStudyThatDoesNotFitIsRefusedNamingItsKeys) {
  try {
    make_experiment(line_scenario({"world.landmarks=127", "study.steps=10000000"}));
    FAIL() << "4 TB were there";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("world.landmarks = 127"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("study.steps = 10000000"), std::string::npos) << error.what();
  }
}

Scenario linear_scenario(const std::string& F, const std::string& H, const std::string& of_noise) {
  return load_scenario_text("[world]\nmodel = \"linear\"\nF = " + F + "\nH = " + H + "\nQ = " + of_noise +
                                "\nP0 = " + of_noise + "\nR = [[1.0]]\n",
                            "t.toml");
}

// By F = 2 noises of one σ add up to 2ᵏ⁺¹ − 1 of it in k steps, of which 2⁻⁵² is 1e-4 first at k = 38.
TEST(RequireExactDifferences, OfAWorldThatGrowsBeyondDoubles) {
  const LinearProblem doubles = linear_problem(linear_scenario("[[2.0]]", "[[1.0]]", "[[1.0]]")).value();
  EXPECT_NO_THROW(require_exact_differences(doubles, 37));
  EXPECT_THROW(require_exact_differences(doubles, 38), ScenarioError);
  const std::string eye = "[[1.0, 0.0], [0.0, 1.0]]";
  const LinearProblem turns =
      linear_problem(linear_scenario("[[0.6, -0.8], [0.8, 0.6]]", "[[1.0, 0.0]]", eye)).value();
  EXPECT_NO_THROW(require_exact_differences(turns, 100'000));
  const LinearProblem moves =
      linear_problem(linear_scenario("[[1.0, 1.0], [0.0, 1.0]]", "[[1.0, 0.0]]", eye)).value();
  EXPECT_NO_THROW(require_exact_differences(moves, 10'000)) << "k² σ";
}

}  // namespace
}  // namespace credence::internal
