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

}  // namespace
}  // namespace credence::internal
