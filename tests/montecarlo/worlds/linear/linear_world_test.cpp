#include "montecarlo/worlds/linear/linear_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

// Lines 1 to 7, so that messages name them.
const std::string kSystem =
    "[world]\n"
    "model = \"linear\"\n"
    "F = [[1, 0.5], [-0.1, 0.9]]\n"
    "H = [[1, 0], [1, 1], [0.5, 0]]\n"
    "Q = [[0.2, 0.1], [0.1, 0.3]]\n"
    "R = [[1, 0, 0], [0, 2, 0], [0, 0, 1]]\n"
    "P0 = [[4, 1], [1, 4]]\n";

Scenario linear_scenario(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return load_scenario_text(text, "s.toml", overrides);
}

std::string linear_refusal(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return scenario_refusal([&] { linear_scenario(text, overrides); });
}

StudyStatistics run(const Experiment& experiment, int threads) {
  const StudyTask task{.id = {}, .experiment = &experiment, .runs = 200};
  return run_studies({&task, 1}, {.threads = threads}).front().statistics;
}

TEST(LinearWorld, ReadsItsMatrices) {
  const LinearProblem p =
      linear_problem(linear_scenario(kSystem +
                                     "G = [[1, 0], [0, 2]]\n[filter]\nR = [[2, 0, 0], [0, 2, 0], [0, 0, 2]]\n"
                                     "process_scale = 2\nmeasurement_scale = 3\n"))
          .value();
  EXPECT_EQ(p.truth.F, (Matrix(2, 2) << 1, 0.5, -0.1, 0.9).finished());
  EXPECT_EQ(p.truth.G, (Matrix(2, 2) << 1, 0, 0, 2).finished());
  EXPECT_EQ(p.truth.H, (Matrix(3, 2) << 1, 0, 1, 1, 0.5, 0).finished());
  EXPECT_EQ(p.truth.P0, (Matrix(2, 2) << 4, 1, 1, 4).finished());
  EXPECT_EQ(p.assumed.Q, (Matrix(2, 2) << 0.4, 0.2, 0.2, 0.6).finished());
  EXPECT_EQ(p.assumed.R, Matrix(6.0 * Matrix::Identity(3, 3)));
  EXPECT_EQ(p.assumed.F, p.truth.F);
  EXPECT_EQ(p.assumed.P0, p.truth.P0);
  EXPECT_EQ(linear_problem(linear_scenario(kSystem)).value().truth.G, Matrix(Matrix::Identity(2, 2)));
  EXPECT_EQ(world_text(linear_scenario(kSystem)), "linear, 2 states, 3 measurements");
}

TEST(LinearWorld, ItsCanonicalTextLoadsTheSame) {
  const Scenario s =
      linear_scenario(kSystem + "states = [\"a.p\", \"a.v\"]\n[filter]\nP0 = [[0.1, 0], [0, 1e-20]]\n");
  Scenario again = linear_scenario(canonical_toml(s));
  again.name = s.name;
  EXPECT_EQ(again, s);
  EXPECT_THAT(canonical_toml(s), HasSubstr("P0 = [[0.1, 0.0], [0.0, 1e-20]]\n"));
  // What the filter believes makes another configuration that meets the same noise.
  EXPECT_NE(configuration_id(linear_scenario(kSystem)),
            configuration_id(linear_scenario(kSystem, {"filter.F=[[1, 0], [0, 1]]"})));
  EXPECT_EQ(noise_group(linear_scenario(kSystem)),
            noise_group(linear_scenario(kSystem, {"filter.F=[[1, 0], [0, 1]]"})));
  EXPECT_NE(noise_group(linear_scenario(kSystem)),
            noise_group(linear_scenario(kSystem, {"world.F=[[1, 0], [0, 1]]"})));
}

// Of messages a long text is cut, of what says which configuration it is none.
TEST(LinearWorld, ItsIdentityDependsOnWholeNames) {
  const std::string stem(80, 'a');
  const auto named = [&](const std::string& last) {
    return linear_scenario(kSystem + "states = [\"" + stem + last + "\", \"b\"]\n");
  };
  EXPECT_NE(configuration_id(named("1")), configuration_id(named("2")));
  Scenario again = linear_scenario(canonical_toml(named("1")));
  again.name = named("1").name;
  EXPECT_EQ(again, named("1"));
}

TEST(LinearWorld, NamesMakeBlocks) {
  const RunLayout layout =
      linear_problem(linear_scenario(kSystem + "states = [\"tank.level\", \"leak\"]\n")).value().scene.layout;
  EXPECT_EQ(layout.states, (std::vector<std::string>{"tank.level", "leak"}));
  ASSERT_EQ(layout.blocks.size(), 2U);
  EXPECT_EQ(layout.blocks[0].name, "tank");
  EXPECT_EQ(linear_problem(linear_scenario(kSystem)).value().scene.layout.states[1], "x2");
  // A single block would be the state once more.
  EXPECT_TRUE(linear_problem(linear_scenario(kSystem + "states = [\"a.p\", \"a.v\"]\n"))
                  .value()
                  .scene.layout.blocks.empty());
}

TEST(LinearWorld, RefusesNamingPlaceKeyAndShape) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {"world.F=[[1, 0], [0, 1, 2]]",
       {"world.F=[[1, 0], [0, 1, 2]]: must be square; it has 2 rows; row 2 has 3 numbers"}},
      {"world.F=[[1, 0]]", {"must be square; it has 1 row; row 1 has 2 numbers"}},
      {"world.F=3", {"must be a matrix of finite numbers, [[row], [row], …], not the integer 3"}},
      {"world.F=[]", {"must be a matrix of finite numbers"}},
      {"world.F=[[]]", {"must be square; it has 1 row; row 1 has 0 numbers"}},
      {"world.F=[1, 2]", {"must be a matrix of finite numbers", "not the array [1, 2]"}},
      {"world.F=[[1, 0], [inf, 1]]", {"row 2, column 1 is inf"}},
      {"world.F=[[1, nan], [0, 1]]", {"row 1, column 2 is nan"}},
      {"world.F=[[1, \"a\"], [0, 1]]", {"row 1, column 2 is \"a\""}},
      {"world.F=[[[1]]]", {"row 1, column 1 is an array"}},
      {"world.H=[[1, 0], [1, 1, 3]]", {"must be m×2, as world.F is 2×2; row 2 has 3 numbers"}},
      {"world.Q=[[1]]", {"must be 2×2, as world.F is 2×2 and world.G is not given; row 1 has 1 number"}},
      {"world.G=[[1], [2]]", {"[world] Q", "must be 1×1, as world.G is 2×1; row 1 has 2 numbers"}},
      {"world.G=[[1]]", {"world.G=[[1]]: must be 2×q, as world.F is 2×2; it has 1 row"}},
      {"world.R=[[1, 0], [0, 1]]", {"must be 3×3, as world.H is 3×2; row 1 has 2 numbers"}},
      {"world.P0=[[1, 0.5], [0.4, 1]]",
       {"must be symmetric; row 2, column 1 is 0.4, and row 1, column 2 is 0.5"}},
      {"world.Q=[[1, 2], [2, 1]]", {"must be positive semidefinite; its least eigenvalue is -1"}},
      {"world.states=[\"a\"]", {"must be 2 names, as world.F is 2×2"}},
      {"world.states=[\"a\", \"a\"]", {"must be an array of different names; element 2 is \"a\""}},
      {"filter.F=[[1]]", {"must be 2×2, as world.F is 2×2; row 1 has 1 number"}},
      {"filter.H=[[1, 0]]", {"must be 3×2, as world.H is 3×2; it has 1 row"}},
      {"filter.R=[[1]]", {"must be 3×3, as world.R is 3×3"}},
      {"filter.G=[[1], [1]]", {"needs a filter.Q of 1×1, since world.Q is 2×2"}},
      {"filter.P0=[[-1, 0], [0, 1]]", {"must be positive semidefinite"}},
      {"world.landmarks=3", {"accepted only with world.model = \"monobot\" or \"planar\""}},
      {"filter.inflation=map", {"accepted only with world.model = \"monobot\" or \"planar\""}},
      {"world.Hh=[[1]]", {"unknown key, did you mean H?"}},
  };
  for (const auto& [wrong, said] : cases) {
    const std::string message = linear_refusal(kSystem, {wrong});
    for (const std::string& part : said) EXPECT_THAT(message, HasSubstr(part)) << wrong;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  // Files name the line.
  EXPECT_THAT(linear_refusal(kSystem + "states = [\"a\"]\n"),
              StartsWith("s.toml:8: [world] states = [\"a\"]: must be 2"));
  EXPECT_EQ(linear_refusal("[world]\nmodel = \"linear\"\nF = [[1]]\n"),
            "s.toml: [world] H is missing: must be a matrix of finite numbers, [[row], [row], …]");
  EXPECT_THAT(linear_refusal(kSystem, {"world.R=[[1, 0.5, 0], [0.5, 1, 0], [0, 0, 1]]",
                                       "noise.detection_probability=0.5"}),
              HasSubstr("must be 1 where world.R or filter.R is not diagonal"));
}

TEST(LinearWorld, SingularCovariancesAreLegal) {
  for (const char* singular : {"world.Q=[[0, 0], [0, 0]]", "world.P0=[[0, 0], [0, 0]]",
                               "world.P0=[[0.1, 0.3], [0.3, 0.9]]", "filter.Q=[[1, 0], [0, 0]]"}) {
    EXPECT_EQ(linear_refusal(kSystem, {singular}), "accepted") << singular;
    const StudyStatistics statistics = run(*make_experiment(linear_scenario(kSystem, {singular})), 1);
    EXPECT_TRUE(statistics.failures.empty()) << singular;
  }
}

// Rank one at every step, whatever rounding says; and a state that is known after every measurement.
TEST(LinearWorld, NeesCountsTheDirectionsThatHaveAVariance) {
  const std::string line =
      "[world]\nmodel = \"linear\"\nF = [[0.5, 0.4], [0.4, 0.5]]\nG = [[1], [1]]\nH = [[1, 0.5]]\n"
      "Q = [[0.3]]\nR = [[1]]\nP0 = [[2, 2], [2, 2]]\n";
  const std::string exact =
      "[world]\nmodel = \"linear\"\nF = [[1, 1], [0, 0.9]]\nH = [[1, 0]]\n"
      "Q = [[0.1, 0.02], [0.02, 0.3]]\nR = [[0]]\nP0 = [[1, 0], [0, 1]]\n";
  for (const std::string& text : {line, exact}) {
    for (const StepStatistics& step : run(*make_experiment(linear_scenario(text)), 1).steps) {
      ASSERT_EQ(step.nees_dof, 200);
      EXPECT_NEAR(step[Quantity::nees].mean, 1.0, 5.0 * std::sqrt(2.0 / 200.0));
    }
  }
}

// What is unstable and not observed grows until the variance of its squares is no number: the runs end there,
// and say so.
TEST(LinearWorld, ErrorsBeyondAllStatisticsEndTheRun) {
  const Scenario s = linear_scenario(
      "[world]\nmodel = \"linear\"\nF = [[2, 0], [0, 0.5]]\nH = [[0, 1]]\nQ = [[1, 0], [0, 1]]\n"
      "R = [[1]]\nP0 = [[1, 0], [0, 1]]\n[study]\nsteps = 600\n");
  const StudyStatistics statistics = run(*make_experiment(s), 1);
  ASSERT_EQ(statistics.failures.size(), 200U);
  EXPECT_EQ(statistics.failures.front().step, 249);  // 4/3 4^249 is beyond 1e150
}

TEST(LinearWorld, SweepsNumbersAndNoMatrices) {
  const auto plan = [](const std::string& sweep) {
    return plan_sweep(read_scenario_text(kSystem + "[sweep]\n" + sweep, "s.toml"));
  };
  EXPECT_EQ(plan("filter.process_scale = [0.5, 1, 2]\nstudy.seed = \"1:2\"\n").points.size(), 6U);
  try {
    plan("world.F = [[1, 0], [0, 1]]\n");
    FAIL() << "a matrix was swept";
  } catch (const ScenarioError& error) {
    EXPECT_THAT(error.what(), HasSubstr("s.toml:9: [sweep] world.F"));
    EXPECT_THAT(error.what(), HasSubstr("cannot be swept, since it is an array"));
  }
}

const std::vector<std::vector<std::string>> kVariants = {
    {},
    {"filter.F=[[1, 0.4], [-0.1, 0.8]]", "filter.H=[[1, 0], [1, 0.9], [0.5, 0]]"},
    {"noise.detection_probability=0.6"},
    {"noise.detection_probability=0.6", "filter.F=[[1, 0.4], [-0.1, 0.8]]"},
    {"world.P0=[[1, 1], [1, 1]]", "world.Q=[[0, 0], [0, 0]]"}};

TEST(LinearWorld, ThreadsGiveTheSameBits) {
  for (const auto& variant : kVariants) {
    const auto experiment = make_experiment(linear_scenario(kSystem, variant));
    EXPECT_EQ(to_bytes(run(*experiment, 1)), to_bytes(run(*experiment, 2)));
  }
}

TEST(LinearWorld, TellsTheMemoryThatItNeeds) {
  const Scenario small = linear_scenario(kSystem), longer = linear_scenario(kSystem, {"study.steps=1000000"});
  EXPECT_GT(least_experiment_bytes(longer), 1e6 * 8.0 * 12.0);
  EXPECT_LT(least_experiment_bytes(small), 1e6);
}

// `run` plays any of its estimators; what needs a Riccati equation is not told that it has one.
TEST(LinearWorld, PlaysItsEstimators) {
  const std::string filter = "[filter]\ngain = [[0.5, 0, 0], [0, 0.2, 0]]\nconsidered = [\"x2\"]\n";
  for (const char* name : {"steady-state", "smoother", "schmidt", "own-gain"}) {
    const Scenario s =
        linear_scenario(kSystem + filter, {std::string("filter.estimator=") + name, "study.steps=20"});
    EXPECT_FALSE(linear_problem(s)) << name;
    EXPECT_THAT(world_text(s), HasSubstr(name));
    const auto experiment = make_experiment(s);
    const StudyStatistics statistics = run(*experiment, 1);
    ASSERT_EQ(statistics.steps.size(), 20U);
    const Moments& nees = statistics.steps.back()[Quantity::nees];
    EXPECT_NEAR(nees.mean, 2.0, 5.0 * 2.0 / std::sqrt(200.0)) << name;
  }
  EXPECT_TRUE(linear_problem(linear_scenario(kSystem + filter)));
  EXPECT_THAT(linear_refusal(kSystem + "[filter]\ngain = [[1, 0, 0]]\n"), HasSubstr("gain"));
  EXPECT_THAT(linear_refusal(kSystem + "[filter]\nconsidered = [\"x3\"]\n"), HasSubstr("x3"));
  EXPECT_THROW(make_experiment(linear_scenario(kSystem, {"filter.estimator=own-gain"})),
               std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
