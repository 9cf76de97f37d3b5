#pragma once

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/nan.h"
#include "montecarlo/random/delay_line.h"
#include "montecarlo/worlds/charted/charted_settings.h"
#include "montecarlo/worlds/world_stream.h"

namespace credence::internal {

/// What aids the filter as numbers of the stream: a satellite's fix as it is, landmarks each at its place.
inline Vector numbers_of_aiding(const Aiding& seen, Index numbers) {
  if (seen.landmarks.empty()) return seen.z;
  const Index d = seen.z.size() / std::ssize(seen.landmarks);
  Vector all = Vector::Constant(numbers, kNaN);
  for (std::size_t i = 0; i < seen.landmarks.size(); ++i) {
    all.segment(d * seen.landmarks[i], d) = seen.z.segment(d * static_cast<Index>(i), d);
  }
  return all;
}

/// What a world in a Lie group tells: its states in coordinates, what is read of its motion, and what aids
/// the filter: a vector of a satellite's fix, or the relative position of each landmark.
template <ChartedModel Model>
WorldStream charted_stream(const Scenario& scenario) {
  const auto model = std::make_shared<const Model>(scenario);
  const RunLayout layout = model->layout();
  WorldStream stream{.states = layout.states,
                     .measurements = {},
                     .notes = fmt::format("state = {}\n", Model::kCoordinates),
                     .visit = {}};
  constexpr Index kInputs = Model::Input::RowsAtCompileTime;
  for (Index i = 1; i <= kInputs; ++i) stream.inputs.push_back(std::to_string(i));
  const auto& landmarks = model->landmarks();
  const bool by_landmarks = aided_by_landmarks(scenario);
  const Index dim = by_landmarks ? landmarks.front().size() : layout.sensors.front().dim;
  std::vector<std::string> numbers;
  for (Index i = 1; i <= dim; ++i) numbers.push_back(std::to_string(i));
  stream.measurements = by_landmarks ? names_of_landmarks(landmarks.size(), numbers) : numbers;
  if (by_landmarks) stream.notes += text_of_landmarks(landmarks);
  stream.visit = [world = ChartedWorld<Model>(model, Chart::componentwise),
                  settings = plug_settings(scenario),
                  count = std::ssize(stream.measurements)](std::int64_t run, const RowVisitor& take) {
    const NoiseSource source = settings.source();
    DelayLine<std::optional<Aiding>> line(settings.measurement_delay);
    NoiseDraw initial(source, run, 0, NoisePurpose::initial);
    auto truth = world.initial(initial);
    take(0, {.prior = world.coordinates(world.prior().mean), .truth = world.coordinates(truth)});
    for (std::int64_t k = 1; k <= settings.steps; ++k) {
      NoiseDraw process(source, run, k, NoisePurpose::process);
      truth = world.step(truth, k, process);
      NoiseDraw input(source, run, k, NoisePurpose::process, plugged::kInputSlots);
      StreamRow row{.truth = world.coordinates(truth), .input = world.input(truth, k, input)};
      NoiseDraw measurement(source, run, k, NoisePurpose::measurement);
      const auto seen = line.pass(world.measure(truth, k, measurement));
      if (seen && *seen) row.measurement = numbers_of_aiding(**seen, count);
      take(k, row);
    }
  };
  return stream;
}

}  // namespace credence::internal
