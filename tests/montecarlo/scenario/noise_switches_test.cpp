// The switches of [noise] in every world.
#include "montecarlo/scenario/noise_switches.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/filters/linear_filter.h"
#include "core/linear_algebra/cholesky.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

constexpr Index kSwitchSteps = 24, kDelay = 3;

const std::string kLinear =
    "[world]\nmodel = \"linear\"\nF = [[1, 0.5], [0, 0.9]]\nH = [[1, 0], [1, 1]]\n"
    "Q = [[0.2, 0.1], [0.1, 0.3]]\nR = [[1, 0.3], [0.3, 2]]\nP0 = [[4, 1], [1, 4]]\n";

/// A scenario of this world, short, that measures at every step.
Scenario scenario_of(std::string_view model, std::vector<std::string> overrides) {
  overrides.push_back(fmt::format("study.steps={}", kSwitchSteps));
  if (model == "localisation" || model == "inertial") overrides.emplace_back("world.aiding_interval=1");
  const bool missed = !overrides.empty() && overrides.front().starts_with("noise.detection");
  if (model == "linear" && missed) overrides.emplace_back("world.R=[[1, 0], [0, 2]]");
  const std::string text = model == "linear" ? kLinear : fmt::format("[world]\nmodel = \"{}\"\n", model);
  return load_scenario_text(text, "t.toml", overrides);
}

StudyStatistics chunk_of(std::string_view model, const std::vector<std::string>& overrides) {
  return make_experiment(scenario_of(model, overrides))->run_chunk(0, 8);
}

const std::vector<std::string> kSwitches = {
    "noise.outlier_rate=0.2",        "noise.student_dof=3",       "noise.measurement_correlation=0.9",
    "noise.process_correlation=0.9", "noise.measurement_delay=3", "noise.detection_probability=0.6",
};

TEST(NoiseSwitches, EachChangesEveryWorldAndIsNamed) {
  for (const World* world : worlds()) {
    const std::string_view model = world->schema.name;
    const Scenario plain = scenario_of(model, {});
    EXPECT_EQ(canonical_toml(plain).find("outlier"), std::string::npos) << "an old identity has changed";
    for (const std::string& name : kSwitches) {
      const Scenario scenario = scenario_of(model, {name});
      EXPECT_NE(configuration_id(scenario), configuration_id(plain)) << model << ' ' << name;
      EXPECT_NE(world_text(scenario), world_text(plain)) << model << ' ' << name;
      EXPECT_EQ(load_scenario_text(canonical_toml(scenario), "again.toml"),
                [&] {
                  Scenario same = scenario;
                  same.name = "again";
                  return same;
                }())
          << model << ' ' << name;
    }
  }
}

// In its chunk and alone a run has the same numbers, whatever the noise.
TEST(NoiseSwitches, AChunkIsItsRuns) {
  for (const World* world : worlds()) {
    for (const std::string& name : kSwitches) {
      const auto experiment = make_experiment(scenario_of(world->schema.name, {name}));
      const StudyStatistics chunk = experiment->run_chunk(0, 4);
      std::vector<double> sums(static_cast<std::size_t>(kSwitchSteps), 0.0);
      std::vector<double> counts(static_cast<std::size_t>(kSwitchSteps), 0.0);
      for (std::int64_t run = 0; run < 4; ++run) {
        experiment->visit(run, [&](const TraceStep& step) {
          if (step.step == 0 || step.outcome != Outcome::ok || step.nees_dof == 0) return;
          sums[static_cast<std::size_t>(step.step) - 1] += step.nees;
          counts[static_cast<std::size_t>(step.step) - 1] += 1.0;
        });
      }
      for (std::size_t k = 0; k < sums.size(); ++k) {
        const double mean = sums[k] / counts[k];
        EXPECT_NEAR(chunk.steps[k][Quantity::nees].mean, mean, 1e-6 * (1.0 + std::abs(mean)))
            << world->schema.name << ' ' << name << ' ' << k;
      }
    }
  }
}

TEST(NoiseSwitches, NothingArrivesBeforeTheDelay) {
  for (const World* world : worlds()) {
    const StudyStatistics late = chunk_of(world->schema.name, {"noise.measurement_delay=3"});
    for (std::size_t k = 0; k < kDelay; ++k) {
      EXPECT_EQ(late.steps[k].nis_dof, 0) << world->schema.name << ' ' << k;
    }
    std::int64_t later = 0;
    for (const StepStatistics& step : late.steps) later += step.nis_dof;
    EXPECT_GT(later, 0) << world->schema.name;
  }
}

// With a sensor that hardly errs a late measurement is the state of then.
TEST(NoiseSwitches, ALateMeasurementIsThatOfThen) {
  const auto experiment = make_experiment(
      scenario_of("linear", {"noise.measurement_delay=3", "world.R=[[1e-18, 0], [0, 1e-18]]"}));
  const RunTrace trace = experiment->trace(2);
  for (std::size_t k = kDelay + 1; k < trace.steps.size(); ++k) {
    EXPECT_NEAR(trace.steps[k].z[0], trace.steps[k - kDelay].truth[0], 1e-7) << k;
  }
}

/// The filter of kLinear, and Σ of its error in a world whose R is so many times larger.
std::vector<double> expected_nees(double factor) {
  const LinearProblem p = linear_problem(scenario_of("linear", {})).value();
  const auto steps = linear_filter_steps(p.assumed, {}, kSwitchSteps);
  Matrix Sigma = p.truth.P0;
  std::vector<double> nees;
  for (const LinearFilterStep& step : steps) {
    const Matrix prior = p.truth.F * Sigma * p.truth.F.transpose() + p.truth.Q;
    const Matrix A = Matrix::Identity(2, 2) - step.K * p.truth.H;
    Sigma = A * prior * A.transpose() + step.K * (factor * p.truth.R) * step.K.transpose();
    nees.push_back(Eigen::LLT<Matrix>(step.P).solve(Sigma).trace());
  }
  return nees;
}

// A linear error has the covariance that the second moments of the noise give it, whatever its law: white
// noise of Student's t and the same variance changes no mean, outliers multiply R by 1 + rate (scale² − 1).
TEST(NoiseSwitches, MeansOfALinearFilterFollowFromTheVarianceOfItsNoise) {
  constexpr std::int64_t kRuns = 6000;
  const auto expect = [&](const std::string& name, double factor) {
    const auto experiment = make_experiment(scenario_of("linear", {name, "noise.outlier_scale=4"}));
    const StudyTask task{.id = {}, .experiment = experiment.get(), .runs = kRuns};
    const StudyStatistics s = run_studies({&task, 1}, {.threads = 1}).front().statistics;
    const std::vector<double> wanted = expected_nees(factor);
    for (const std::size_t k : {0U, 5U, 23U}) {
      const Moments& nees = s.steps[k][Quantity::nees];
      const double error = 5.0 * std::sqrt(nees.variance() / static_cast<double>(kRuns));
      EXPECT_NEAR(nees.mean, wanted[k], error) << name << ", step " << k + 1;
      if (factor > 1.0) {
        EXPECT_GT(nees.mean, 2.0 + error) << "no power";
      }
    }
  };
  expect("noise.student_dof=5", 1.0);
  expect("noise.outlier_rate=0.1", 1.0 + 0.1 * 15.0);
}

// Of a state that stands still the innovations are w but for what little the filter learns.
TEST(NoiseSwitches, CorrelatedNoiseCorrelatesInnovations) {
  const auto experiment = make_experiment(
      scenario_of("linear", {"noise.measurement_correlation=0.8", "world.Q=[[0, 0], [0, 0]]",
                             "world.P0=[[1e-12, 0], [0, 1e-12]]", "world.R=[[1, 0], [0, 1]]"}));
  constexpr std::int64_t kRuns = 4000;
  double lagged = 0.0, squares = 0.0, count = 0.0;
  for (std::int64_t run = 0; run < kRuns; ++run) {
    double before = 0.0;
    experiment->visit(run, [&](const TraceStep& step) {
      if (step.step == 0) return;
      const double now = step.innovation()[0];
      if (step.step > 1) lagged += before * now;
      squares += now * now;
      count += 1.0;
      before = now;
    });
  }
  // Runs are independent: the mean product of a run has at most the variance of a single one, 1 + ρ².
  const double pairs = count - static_cast<double>(kRuns);
  EXPECT_NEAR(lagged / pairs, 0.8, 5.0 * std::sqrt(2.0 / kRuns));
  EXPECT_NEAR(squares / count, 1.0, 5.0 * std::sqrt(2.0 / kRuns));
}

TEST(NoiseSwitches, RefusesWhatCannotBe) {
  const auto refusal = [](const std::string& override) -> std::string {
    return scenario_refusal([&] { scenario_of("linear", {override}); });
  };
  EXPECT_THAT(refusal("noise.student_dof=2"), HasSubstr("must be 0 (Gaussian) or >= 3"));
  EXPECT_THAT(refusal("noise.outlier_rate=1.5"), HasSubstr("a number >= 0 and <= 1"));
  EXPECT_THAT(refusal("noise.measurement_correlation=1"), HasSubstr("<= 0.9999"));
  EXPECT_THAT(refusal("noise.measurement_delay=-1"), HasSubstr("an integer from 0"));
}

}  // namespace
}  // namespace credence::internal
