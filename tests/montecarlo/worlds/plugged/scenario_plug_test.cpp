#include "montecarlo/worlds/plugged/scenario_plug.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"

namespace credence::internal {
namespace {

Scenario pendulum_scenario(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"pendulum\"\n", "t.toml", overrides);
}

// A plugged study of a scenario meets the numbers of the scenario's own source of noise.
TEST(PlugSettings, OfAScenarioHaveItsNoiseAndItsSteps) {
  const Scenario scenario = pendulum_scenario({"study.steps=17", "study.seed=5", "noise.outlier_rate=0.1",
                                               "noise.measurement_delay=3", "noise.student_dof=5"});
  const PlugSettings settings = plug_settings(scenario);
  EXPECT_EQ(settings.steps, 17);
  EXPECT_EQ(settings.seed, 5U);
  EXPECT_EQ(settings.measurement_delay, 3);
  EXPECT_EQ(settings.noise_group, noise_group(scenario));
  const NoiseSource own = settings.source(), of_scenario = noise_source(scenario);
  EXPECT_FALSE(own.is_plain());
  EXPECT_NE(own.process_shape(), own.measurement_shape());
  for (const NoisePurpose purpose :
       {NoisePurpose::initial, NoisePurpose::process, NoisePurpose::measurement}) {
    for (std::int64_t step = 1; step < 20; ++step) {
      EXPECT_EQ(own.normal(2, step, purpose, 1), of_scenario.normal(2, step, purpose, 1)) << step;
    }
  }
}

FunctionModel one_number() {
  FunctionModel model;
  model.f = model.h = [](const Vector& x) { return x; };
  model.Q = model.R = model.P0 = Matrix::Identity(1, 1);
  model.mean = Vector::Zero(1);
  return model;
}

// Missed steps change no measurement of the others; 5 standard errors of a share.
TEST(MissingWorld, AStepIsMissedWithItsProbabilityAndElseIsTheSame) {
  const FunctionWorld whole(one_number());
  const NoiseSource source(3, 0);
  constexpr int kRuns = 4000;
  for (const double detection : {1.0, 0.3}) {
    const MissingWorld world(whole, detection);
    int seen = 0;
    for (std::int64_t run = 0; run < kRuns; ++run) {
      NoiseDraw noise(source, run, 1, NoisePurpose::measurement),
          same(source, run, 1, NoisePurpose::measurement);
      const std::optional<Vector> z = world.measure(Vector::Ones(1), 1, noise);
      if (!z) continue;
      ++seen;
      ASSERT_EQ(*z, whole.measure(Vector::Ones(1), 1, same));
    }
    const double error = std::sqrt(detection * (1.0 - detection) / kRuns);
    EXPECT_NEAR(seen / static_cast<double>(kRuns), detection, 5.0 * error);
  }
}

}  // namespace
}  // namespace credence::internal
