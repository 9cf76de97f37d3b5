#include "datasets/logs/autopilot/innovation_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/append_item.h"
#include "datasets/logs/log_format.h"

namespace credence::internal {

int estimator_number(double said, const ByteCursor& message) {
  constexpr double kLargest = 255.0;
  if (!(said >= 0.0 && said <= kLargest) || std::floor(said) != said) {
    message.fail(fmt::format("an estimator of number {}: corrupted", said));
  }
  return static_cast<int>(said);
}

std::size_t InnovationSeries::sensor(const std::string& name, Index dim, bool angle) {
  const auto known = std::ranges::find(sensors_, name, &SensorSeries::name);
  const auto number = static_cast<std::size_t>(known - sensors_.begin());
  if (known == sensors_.end()) sensors_.push_back({.name = name, .dim = dim, .angle = angle});
  return number;
}

InnovationSeries::Row InnovationSeries::add(std::size_t sensor, double time_s, std::span<const double> nu,
                                            std::span<const double> variances, std::span<const double> said) {
  SensorSeries& s = sensors_[sensor];
  const bool known = std::ranges::all_of(variances, [](double v) { return std::isfinite(v) && v > 0.0; }) &&
                     std::ranges::all_of(nu, [](double v) { return std::isfinite(v); });
  if (!known) return Row::silent;
  if (said.empty()) said = nu;
  if (!s.nu.empty() && std::ranges::equal(said, s.last_said)) {
    ++s.repeated;
    return Row::repeated;
  }
  if (s.nu.empty()) s.first_s = time_s;
  s.last_s = time_s;
  s.last_said.assign(said.begin(), said.end());
  s.nu.insert(s.nu.end(), nu.begin(), nu.end());
  s.variances.insert(s.variances.end(), variances.begin(), variances.end());
  return Row::taken;
}

std::size_t InnovationSeries::nis_sensor(const std::string& name) {
  const std::size_t number = sensor(name, 1, false);
  sensors_[number].nis_alone = true;
  return number;
}

InnovationSeries::Row InnovationSeries::add_nis(std::size_t sensor, double time_s, double nis) {
  if (!(nis > 0.0) || !std::isfinite(nis)) return Row::silent;  // 0: the sensor is not in use
  const double unused = 1.0;
  return add(sensor, time_s, std::span(&nis, 1), std::span(&unused, 1));
}

bool InnovationSeries::empty() const { return std::ranges::none_of(sensors_, &SensorSeries::in_use); }

bool InnovationSeries::any_vector() const {
  return std::ranges::any_of(sensors_, [](const SensorSeries& s) { return s.dim > 1 && s.in_use(); });
}

void InnovationSeries::emit(LogSink& sink) const {
  RunLayout layout;
  layout.has_truth = false;
  std::vector<const SensorSeries*> speaking;
  std::int64_t steps = 0;
  for (const SensorSeries& s : sensors_) {
    if (!s.in_use()) continue;
    speaking.push_back(&s);
    steps = std::max(steps, s.count());
    layout.sensors.push_back({.name = s.name, .dim = s.dim, .piece = s.dim});
    layout.sensors.back().nis_alone = s.nis_alone;
    layout.sensors.back().variances_alone = s.dim > 1;
    if (s.angle) layout.sensors.back().angles = {true};
  }
  sink.begin_run(layout);
  Step step;
  step.innovations.resize(speaking.size());
  for (std::int64_t k = 0; k < steps; ++k) {
    step.step = step.line = k + 1;
    for (std::size_t i = 0; i < speaking.size(); ++i) {
      const SensorSeries& s = *speaking[i];
      if (k >= s.count()) {
        step.innovations[i] = {};
        continue;
      }
      const auto from = static_cast<std::size_t>(k * s.dim);
      if (s.nis_alone) {
        step.innovations[i] = nis_alone(s.nu[from]);
        continue;
      }
      step.innovations[i].nu = Eigen::Map<const Vector>(s.nu.data() + from, s.dim);
      step.innovations[i].S = Eigen::Map<const Vector>(s.variances.data() + from, s.dim).asDiagonal();
    }
    sink.add(step);
  }
}

std::string InnovationSeries::counts() const {
  std::string text;
  for (const SensorSeries& s : sensors_) {
    if (!s.in_use()) continue;
    append_item(text, fmt::format("{} of {}", s.count(), s.name));
    const double rate = message_rate(s.count(), s.first_s, s.last_s);
    if (std::isfinite(rate)) text += fmt::format(" ({:.3g} Hz)", rate);
  }
  return text;
}

std::string InnovationSeries::never_repeated() const {
  constexpr std::int64_t kEnough = 20;
  std::string text;
  for (const SensorSeries& s : sensors_) {
    if (s.repeated == 0 && s.count() >= kEnough) append_item(text, s.name);
  }
  return text;
}

}  // namespace credence::internal
