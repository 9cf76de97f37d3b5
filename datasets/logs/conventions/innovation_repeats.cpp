#include "datasets/logs/conventions/innovation_repeats.h"

#include <fmt/format.h>

#include <algorithm>

namespace credence::internal {

void InnovationRepeats::begin_run(const RunLayout& layout) {
  sensors_.resize(layout.sensors.size());
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    sensors_[i].name = layout.sensors[i].name;
    sensors_[i].last.resize(0);
  }
  ForwardingSink::begin_run(layout);
}

void InnovationRepeats::add(const Step& step) {
  ForwardingSink::add(step);
  for (std::size_t i = 0; i < std::min(sensors_.size(), step.innovations.size()); ++i) {
    const Vector& nu = step.innovations[i].nu;
    if (nu.size() == 0) continue;
    OfSensor& sensor = sensors_[i];
    ++sensor.rows;
    if (nu.isZero(0.0)) {
      ++sensor.zeros;
    } else if (sensor.last.size() == nu.size() && sensor.last == nu) {
      ++sensor.repeats;
    }
    sensor.last = nu;
    for (std::size_t other = 0; other < i; ++other) {
      const Vector& first = step.innovations[other].nu;
      if (first.size() != nu.size() || first != nu || nu.isZero(0.0)) continue;
      ++sensor.copies;
      sensor.copied = sensors_[other].name;
      break;
    }
  }
}

void InnovationRepeats::finish() {
  constexpr std::int64_t kFewest = 20;
  constexpr const char* kNothing =
      "where nothing was measured there is none, which is written as NaN, or in a CSV as empty fields";
  for (const OfSensor& sensor : sensors_) {
    const auto say = [&sensor, this](std::int64_t count, const std::string& what, const char* why) {
      if (sensor.rows < kFewest || 2 * count < sensor.rows) return;
      mistake(fmt::format("{} of {} innovations{} are {}: {}.", count, sensor.rows,
                          sensor.name.empty() ? "" : fmt::format(" of {}", sensor.name), what, why));
    };
    say(sensor.repeats, "those of the row before to the last bit", kNothing);
    say(sensor.zeros, "exactly zero", kNothing);
    say(sensor.copies, fmt::format("those of {} to the last bit", sensor.copied),
        "one measurement is counted twice");
  }
}

}  // namespace credence::internal
