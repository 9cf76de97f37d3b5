#include "montecarlo/scenario/noise_switches.h"

#include <fmt/format.h>

#include "core/append_item.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/scenario_text.h"

namespace credence::internal {
namespace {

constexpr Interval kProbability{0.0, 1.0, false, false}, kCorrelation{0.0, 0.9999, false, false};

double outlier_rate(const Scenario& s) { return real_value(s, "noise.outlier_rate"); }
std::int64_t student_dof(const Scenario& s) { return integer_value(s, "noise.student_dof"); }
double measured_correlation(const Scenario& s) { return real_value(s, "noise.measurement_correlation"); }
double process_correlation(const Scenario& s) { return real_value(s, "noise.process_correlation"); }

bool has_outliers(const Scenario& s) { return outlier_rate(s) > 0.0; }

KeyRow detection_key() {
  return {
      .section = "noise",
      .name = "detection_probability",
      .unit = "",
      .meaning =
          "chance that a landmark in view (else a component of the measurement) is measured at a step; the "
          "others are missed",
      .field = real_field<&Scenario::noise, &NoiseSettings::detection_probability>({0.0, 1.0, true, false}),
      .in_effect = [](const Scenario& s) { return s.noise.detection_probability < 1.0; }};
}

}  // namespace

std::vector<KeyRow> noise_switch_keys() {
  return {
      detection_key(),
      {.section = "noise",
       .name = "outlier_rate",
       .unit = "",
       .meaning = "chance that the noise of a component of the measurement is multiplied by outlier_scale",
       .field = own_real("noise.outlier_rate", 0.0, kProbability),
       .in_effect = has_outliers},
      {.section = "noise",
       .name = "outlier_scale",
       .unit = "",
       .meaning =
           "standard deviation of an outlier over that of the noise; of no effect with outlier_rate = 0",
       .field = own_real("noise.outlier_scale", 10.0, Interval::kPositive),
       .in_effect = has_outliers},
      {.section = "noise",
       .name = "student_dof",
       .unit = "",
       .meaning =
           "measurement noise by Student's t with so many degrees of freedom, at least 3, and the same "
           "variance; 0: Gaussian",
       .field = own_integer("noise.student_dof", 0, 0, 1000),
       .in_effect = [](const Scenario& s) { return student_dof(s) > 0; }},
      {.section = "noise",
       .name = "measurement_correlation",
       .unit = "",
       .meaning = "correlation of the measurement noise of one step with that of the next (Gauss-Markov)",
       .field = own_real("noise.measurement_correlation", 0.0, kCorrelation),
       .in_effect = [](const Scenario& s) { return measured_correlation(s) > 0.0; }},
      {.section = "noise",
       .name = "process_correlation",
       .unit = "",
       .meaning = "the same of the process noise, or of that of odometry and inertial readings",
       .field = own_real("noise.process_correlation", 0.0, kCorrelation),
       .in_effect = [](const Scenario& s) { return process_correlation(s) > 0.0; }},
      {.section = "noise",
       .name = "measurement_delay",
       .unit = "",
       .meaning = "steps after which a measurement reaches the filter, which takes it for one of that step",
       .field = own_integer("noise.measurement_delay", 0, 0, 1'000'000),
       .in_effect = [](const Scenario& s) { return measurement_delay(s) > 0; }},
  };
}

void check_noise_switches(const Scenario& scenario, const Refusal& refuse) {
  if (student_dof(scenario) == 1 || student_dof(scenario) == 2) {
    refuse.wrong("noise", "student_dof", "must be 0 (Gaussian) or >= 3: below, the noise has no variance");
  }
}

NoiseSource noise_source(const Scenario& scenario) {
  const NoiseShape process{.correlation = process_correlation(scenario)};
  const NoiseShape measurement{.correlation = measured_correlation(scenario),
                               .student_dof = static_cast<int>(student_dof(scenario)),
                               .outlier_rate = outlier_rate(scenario),
                               .outlier_scale = real_value(scenario, "noise.outlier_scale")};
  return NoiseSource(scenario.study.seed, noise_group(scenario)).shaped(process, measurement);
}

Index measurement_delay(const Scenario& scenario) {
  return integer_value(scenario, "noise.measurement_delay");
}

std::string detection_text(const Scenario& scenario) {
  const double seen = scenario.noise.detection_probability;
  return seen < 1.0 ? fmt::format(" with probability {:g}", seen) : "";
}

std::string noise_switches_text(const Scenario& scenario) {
  std::string text;
  if (has_outliers(scenario)) text += fmt::format(", outliers at rate {:g}", outlier_rate(scenario));
  if (student_dof(scenario) > 0) text += fmt::format(", Student's t({}) noise", student_dof(scenario));
  if (const double r = measured_correlation(scenario); r > 0.0) {
    text += fmt::format(", measurement noise correlated by {:g}", r);
  }
  if (const double r = process_correlation(scenario); r > 0.0) {
    text += fmt::format(", process noise correlated by {:g}", r);
  }
  if (const Index delay = measurement_delay(scenario); delay > 0) {
    text += fmt::format(", measured {} late", counted(delay, "step"));
  }
  return text;
}

}  // namespace credence::internal
