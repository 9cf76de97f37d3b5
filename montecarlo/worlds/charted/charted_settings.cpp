#include "montecarlo/worlds/charted/charted_settings.h"

#include <fmt/format.h>

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/worlds/slam_settings.h"

namespace credence::internal {
namespace {

constexpr std::string_view kWithLandmarks =
    "with world.model = \"localisation\" or \"inertial\" and world.aiding = \"landmarks\"";
constexpr std::string_view kWithSatellites =
    "with world.model = \"localisation\" or \"inertial\" and world.aiding = \"satellites\"";

Chart filter_chart(const Scenario& scenario) {
  const std::string_view word = word_value(scenario, "filter.chart");
  for (const Chart chart : {Chart::right, Chart::left, Chart::componentwise_left}) {
    if (word == chart_name(chart)) return chart;
  }
  return Chart::componentwise;
}

}  // namespace

bool aided_by_landmarks(const Scenario& s) { return word_value(s, "world.aiding") == "landmarks"; }
bool aided_by_satellites(const Scenario& s) { return !aided_by_landmarks(s); }

std::vector<KeyRow> charted_keys() {
  return {
      {"world", "aiding", "",
       "what is measured of the world outside: satellites give position (and velocity, to an inertial "
       "system), landmarks their places in the frame of the vehicle",
       own_choice("world.aiding", {"satellites", "landmarks"})},
      {"world", "aiding_interval", "", "steps from one measurement of the world outside to the next",
       own_integer("world.aiding_interval", 100, 1, 1'000'000)},
      {"noise", "position_std", "m", "standard deviation of a measured coordinate",
       own_real("noise.position_std", 1.0, Interval::kNotNegative), aided_by_satellites, kWithSatellites},
      {"noise", "relative_position_std", "m", "standard deviation of each coordinate of a relative position",
       own_real("noise.relative_position_std", 0.1, Interval::kPositive), aided_by_landmarks, kWithLandmarks},
      {"filter", "chart", "",
       "where the filter's error is Gaussian: componentwise, vectors by differences and the rotation in the "
       "axes of the body (componentwise_left: of the world), is the error-state EKF; right, x Exp(e), the "
       "left-invariant EKF; left, Exp(e) x, the right-invariant EKF",
       own_choice("filter.chart", {"componentwise", "componentwise_left", "right", "left"})},
      {"filter", "judged_chart", "",
       "chart in which error and P are judged: the filter's own, or componentwise, P transported",
       own_choice("filter.judged_chart", {"own", "componentwise"})},
      {"filter", "covariance_reset", "",
       "full: a correction carries P to where it moves the estimate, which makes right and left one filter; "
       "none: P keeps its numbers in its chart",
       own_choice("filter.covariance_reset", {"none", "full"})},
      process_scale_key(),
      measurement_scale_key(),
  };
}

AidingSettings aiding_settings(const Scenario& scenario) {
  return {.landmarks = aided_by_landmarks(scenario),
          .interval = integer_value(scenario, "world.aiding_interval"),
          .position_std = real_value(scenario, "noise.position_std"),
          .relative_std = real_value(scenario, "noise.relative_position_std"),
          .detection_probability = scenario.noise.detection_probability};
}

ChartSettings chart_settings(const Scenario& scenario) {
  const Chart own = filter_chart(scenario);
  const bool judged_own = word_value(scenario, "filter.judged_chart") == "own";
  const bool reset = word_value(scenario, "filter.covariance_reset") == "full";
  return {.filter = own,
          .judged = judged_own ? own : Chart::componentwise,
          .reset = reset ? CovarianceReset::full : CovarianceReset::none};
}

std::string charted_text(const Scenario& scenario) {
  const ChartSettings charts = chart_settings(scenario);
  return fmt::format(
      "aided by {} every {} steps{}{}, error in the {} chart{}{}", word_value(scenario, "world.aiding"),
      integer_value(scenario, "world.aiding_interval"), detection_text(scenario),
      noise_switches_text(scenario), chart_name(charts.filter),
      charts.reset == CovarianceReset::full ? ", P reset" : "",
      charts.judged == charts.filter ? "" : fmt::format(", judged in the {} one", chart_name(charts.judged)));
}

}  // namespace credence::internal
