// Linear worlds with known answers: golden/linear_systems, whose values have 50 digits (linear_systems.py).

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/stability/exact_moments.h"
#include "analysis/stability/lifted_model.h"
#include "analysis/stability/riccati.h"
#include "analysis/stability/stability_analysis.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"
#include "tests/paths.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kSteps[] = {1, 10, 50};

struct Known {
  double trace, error_trace, nees, nis;  // of one step
};

struct KnownSystem {
  std::string name;
  std::vector<Known> steps;
  std::string limit;  // of the trace of P before the update
};

std::filesystem::path folder() { return source_folder() / "tests/analysis/stability/golden/linear_systems"; }

std::vector<KnownSystem> known_systems() {
  std::vector<KnownSystem> systems;
  std::ifstream file(folder() / "linear_systems.txt");
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    KnownSystem system;
    words >> system.name;
    for (std::size_t i = 0; i < std::size(kSteps); ++i) {
      Known known{};
      words >> known.trace >> known.error_trace >> known.nees >> known.nis;
      system.steps.push_back(known);
    }
    words >> system.limit;
    EXPECT_TRUE(words) << line;
    systems.push_back(std::move(system));
  }
  return systems;
}

Scenario scenario_of(const KnownSystem& system) { return load_scenario(folder() / (system.name + ".toml")); }

void expect_relative(double got, double expected, const std::string& what) {
  EXPECT_NEAR(got / expected, 1.0, 1e-10) << what << ": got " << got << ", expected " << expected;
}

TEST(LinearSystems, ExactMomentsAreThoseOfFiftyDigits) {
  const std::vector<KnownSystem> systems = known_systems();
  ASSERT_EQ(systems.size(), 12U);
  for (const KnownSystem& system : systems) {
    const Scenario scenario = scenario_of(system);
    const LinearProblem problem = linear_problem(scenario).value();
    const std::vector<LinearModel> truth = problem.truth_period(), assumed = problem.assumed_period();
    const auto steps = linear_filter_steps(std::span(assumed), problem.rule, scenario.study.steps);
    const auto exact = exact_moments(std::span(truth), assumed, steps);
    ASSERT_EQ(std::ssize(exact), scenario.study.steps) << system.name;
    for (std::size_t i = 0; i < std::size(kSteps); ++i) {
      const auto k = static_cast<std::size_t>(kSteps[i] - 1);
      const std::string where = system.name + ", step " + std::to_string(kSteps[i]);
      expect_relative(steps[k].P.trace(), system.steps[i].trace, where + ", tr P");
      expect_relative(exact[k].Sigma.trace(), system.steps[i].error_trace, where + ", tr Sigma");
      expect_relative(exact[k].nees, system.steps[i].nees, where + ", NEES");
      expect_relative(exact[k].nis, system.steps[i].nis, where + ", NIS");
    }
  }
}

TEST(LinearSystems, RiccatiHasTheLimitOfFiftyDigits) {
  int limits = 0;
  for (const KnownSystem& system : known_systems()) {
    const Scenario scenario = scenario_of(system);
    const LinearProblem problem = linear_problem(scenario).value();
    if (system.name == "exact_sensor") {  // R = 0
      EXPECT_THROW(analyse_stability(problem.assumed, problem.rule, scenario.study.steps, 500),
                   std::invalid_argument);
      continue;
    }
    const StabilityAnalysis a = analyse_stability(lifted_model(problem.assumed_period()), problem.rule,
                                                  scenario.study.steps, 500, problem.scene.layout.states);
    if (system.limit == "unbounded") {
      EXPECT_EQ(a.riccati.kind, RiccatiKind::unbounded) << system.name;
      EXPECT_FALSE(a.predicted_bounded) << system.name;
      // What grows is named by the states of the scenario.
      ASSERT_EQ(a.unobservable.size(), 2U);
      EXPECT_NE((a.unobservable[0] + a.unobservable[1]).find("x1"), std::string::npos) << a.unobservable[0];
    } else if (system.limit == "-") {
      // Q = 0: everything is learnt, at the rate 1/k.
      EXPECT_TRUE(a.predicted_bounded) << system.name;
      EXPECT_LT(a.riccati.P.trace(), 1e-4) << to_string(a.riccati.kind) << ' ' << a.riccati.reason;
    } else {
      EXPECT_TRUE(a.riccati.has_limit()) << system.name << ": " << a.riccati.reason;
      EXPECT_TRUE(a.predicted_bounded) << system.name << ": " << a.prediction_reason;
      expect_relative(a.riccati.P.trace(), std::stod(system.limit), system.name + ", Riccati");
      ++limits;
    }
  }
  EXPECT_EQ(limits, 9);
}

// 20,000 runs; the standard error of a mean is the spread of the runs over √20,000.
TEST(LinearSystems, MonteCarloMeansAreWithinFiveStandardErrors) {
  constexpr double kErrors = 5.0;
  constexpr std::int64_t kRuns = 20'000;
  int values = 0;
  for (const KnownSystem& system : known_systems()) {
    const auto experiment = make_experiment(scenario_of(system));
    const StudyTask task{.id = {}, .experiment = experiment.get(), .runs = kRuns};
    const StudyStatistics statistics = run_studies({&task, 1}, {.threads = 1}).front().statistics;
    EXPECT_TRUE(statistics.failures.empty()) << system.name;
    for (std::size_t i = 0; i < std::size(kSteps); ++i) {
      const StepStatistics& step = statistics.steps[static_cast<std::size_t>(kSteps[i] - 1)];
      const Known& known = system.steps[i];
      for (const auto& [quantity, expected] :
           {std::pair(Quantity::nees, known.nees), std::pair(Quantity::nis, known.nis)}) {
        const Moments& m = step[quantity];
        const double error = std::sqrt(m.variance() / static_cast<double>(kRuns));
        EXPECT_NEAR(m.mean, expected, kErrors * error)
            << system.name << ", step " << kSteps[i] << (quantity == Quantity::nees ? ", NEES" : ", NIS");
        EXPECT_GT(error, 0.0);
        ++values;
      }
    }
  }
  EXPECT_EQ(values, 72);
}

}  // namespace
}  // namespace credence::internal
