#include "montecarlo/worlds/charted/charted_settings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "montecarlo/random/noise.h"
#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

Scenario settings_of(const std::vector<std::string>& overrides) {
  return load_scenario_text("[world]\nmodel = \"localisation\"\n", "t.toml", overrides);
}

/// What is measured at step k of a run: landmark i is the number i, twice.
std::optional<Aiding> aided(const AidingSettings& settings, std::int64_t run, std::int64_t k,
                            Index landmarks = 5) {
  const NoiseSource source(3, 1);
  NoiseDraw noise(source, run, k, NoisePurpose::measurement);
  return drawn_aiding(
      settings, k, landmarks, noise, [](NoiseDraw&) { return Vector(Vector::Constant(2, -1.0)); },
      [](Index i, NoiseDraw&) { return Vector(Vector::Constant(2, static_cast<double>(i))); });
}

TEST(ChartedSettings, ChartsAreThoseOfTheirWords) {
  const ChartSettings plain = chart_settings(settings_of({}));
  EXPECT_EQ(plain.filter, Chart::componentwise);
  EXPECT_EQ(plain.judged, Chart::componentwise);
  EXPECT_EQ(plain.reset, CovarianceReset::none);
  struct Word {
    const char* word;
    Chart chart;
  };
  for (const Word& w : {Word{"right", Chart::right},
                        {"left", Chart::left},
                        {"componentwise_left", Chart::componentwise_left}}) {
    const std::string own = std::string("filter.chart=") + w.word;
    EXPECT_EQ(chart_settings(settings_of({own})).filter, w.chart);
    EXPECT_EQ(chart_settings(settings_of({own})).judged, w.chart) << "its own unless asked";
    const ChartSettings judged = chart_settings(
        settings_of({own, "filter.judged_chart=componentwise", "filter.covariance_reset=full"}));
    EXPECT_EQ(judged.filter, w.chart);
    EXPECT_EQ(judged.judged, Chart::componentwise);
    EXPECT_EQ(judged.reset, CovarianceReset::full);
  }
}

TEST(ChartedSettings, AidingIsOfTheScenario) {
  const AidingSettings by_landmarks =
      aiding_settings(settings_of({"world.aiding=landmarks", "world.aiding_interval=7",
                                   "noise.relative_position_std=0.3", "noise.detection_probability=0.25"}));
  EXPECT_TRUE(by_landmarks.landmarks);
  EXPECT_EQ(by_landmarks.interval, 7);
  EXPECT_EQ(by_landmarks.relative_std, 0.3);
  EXPECT_EQ(by_landmarks.detection_probability, 0.25);
  const AidingSettings fixes = aiding_settings(settings_of({"noise.position_std=2"}));
  EXPECT_FALSE(fixes.landmarks);
  EXPECT_EQ(fixes.position_std, 2.0);
  EXPECT_TRUE(aided_by_satellites(settings_of({})));
}

TEST(ChartedSettings, IsMeasuredAtItsStepsAlone) {
  for (std::int64_t k = 1; k <= 12; ++k) {
    EXPECT_EQ(aided({.interval = 4}, 0, k).has_value(), k % 4 == 0) << k;
    EXPECT_EQ(aided({.landmarks = true, .interval = 3}, 0, k).has_value(), k % 3 == 0) << k;
  }
}

TEST(ChartedSettings, AllLandmarksComeInTheirOrder) {
  const auto all = aided({.landmarks = true}, 0, 1);
  EXPECT_EQ(all->landmarks, (std::vector<Index>{0, 1, 2, 3, 4}));
  EXPECT_EQ(all->z, (Vector{{0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0}}));
  EXPECT_FALSE(aided({.landmarks = true}, 0, 1, 0).has_value()) << "of none there is no measurement";
}

TEST(ChartedSettings, EachIsMissedByItselfWithItsProbability) {
  constexpr int kRuns = 2000;
  constexpr double kSeen = 0.3;
  int fixes = 0, both = 0, first = 0, none = 0;
  for (int run = 0; run < kRuns; ++run) {
    fixes += aided({.detection_probability = kSeen}, run, 1).has_value();
    const auto seen = aided({.landmarks = true, .detection_probability = kSeen}, run, 1, 2);
    none += !seen.has_value();
    if (!seen) continue;
    // What is there is the measurement of those that are named.
    for (std::size_t i = 0; i < seen->landmarks.size(); ++i) {
      EXPECT_EQ(seen->z[2 * static_cast<Index>(i)], static_cast<double>(seen->landmarks[i]));
    }
    first += seen->landmarks.front() == 0;
    both += seen->landmarks.size() == 2;
  }
  const auto expect_share = [&](int count, double share) {
    EXPECT_NEAR(count, kRuns * share, 5.0 * std::sqrt(kRuns * share * (1.0 - share)));
  };
  expect_share(fixes, kSeen);
  expect_share(first, kSeen);
  expect_share(both, kSeen * kSeen);
  expect_share(none, (1.0 - kSeen) * (1.0 - kSeen));
}

TEST(ChartedSettings, SayWhatTheFilterIs) {
  EXPECT_EQ(charted_text(settings_of({})),
            "aided by satellites every 100 steps, error in the componentwise chart");
  EXPECT_EQ(
      charted_text(settings_of({"world.aiding=landmarks", "world.aiding_interval=5", "filter.chart=left",
                                "filter.covariance_reset=full", "filter.judged_chart=componentwise",
                                "noise.detection_probability=0.5"})),
      "aided by landmarks every 5 steps with probability 0.5, error in the left chart, P reset, judged in "
      "the "
      "componentwise one");
}

}  // namespace
}  // namespace credence::internal
