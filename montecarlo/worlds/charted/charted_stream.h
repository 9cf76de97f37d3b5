#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "montecarlo/random/delay_line.h"
#include "montecarlo/worlds/charted/charted_settings.h"
#include "montecarlo/worlds/world_stream.h"

namespace credence {

/// What a world in a Lie group tells: its states in coordinates, what is read of its motion, and what aids
/// the filter: a vector of a satellite's fix, or the relative position of each landmark.
template <ChartedModel Model>
class ChartedStream final : public WorldStream {
 public:
  explicit ChartedStream(const Scenario& scenario)
      : model_(std::make_shared<const Model>(scenario)),
        world_(model_, Chart::componentwise),
        settings_(plug_settings(scenario)),
        by_landmarks_(aided_by_landmarks(scenario)) {
    const RunLayout layout = model_->layout();
    states = layout.states;
    constexpr Index kInputs = Model::Input::RowsAtCompileTime;
    for (Index i = 1; i <= kInputs; ++i) inputs.push_back(std::to_string(i));
    notes = fmt::format("state = {}\n", Model::kCoordinates);
    const auto& landmarks = model_->landmarks();
    std::vector<std::string> numbers;
    const Index dim = by_landmarks_ ? landmarks.front().size() : layout.sensors.front().dim;
    for (Index i = 1; i <= dim; ++i) numbers.push_back(std::to_string(i));
    measurements = by_landmarks_ ? names_of_landmarks(landmarks.size(), numbers) : numbers;
    if (by_landmarks_) notes += text_of_landmarks(landmarks);
  }

  void visit(std::int64_t run,
             const std::function<void(std::int64_t, const StreamRow&)>& take) const override {
    const NoiseSource source = settings_.source();
    DelayLine<std::optional<Aiding>> line(settings_.measurement_delay);
    NoiseDraw initial(source, run, 0, NoisePurpose::initial);
    auto truth = world_.initial(initial);
    take(0, {.prior = world_.coordinates(world_.prior().mean), .truth = world_.coordinates(truth)});
    for (std::int64_t k = 1; k <= settings_.steps; ++k) {
      NoiseDraw process(source, run, k, NoisePurpose::process);
      truth = world_.step(truth, k, process);
      NoiseDraw input(source, run, k, NoisePurpose::process, plugged::kInputSlots);
      StreamRow row{.truth = world_.coordinates(truth), .input = world_.input(truth, k, input)};
      NoiseDraw measurement(source, run, k, NoisePurpose::measurement);
      const auto seen = line.pass(world_.measure(truth, k, measurement));
      if (seen && *seen) row.measurement = numbers_of(**seen);
      take(k, row);
    }
  }

 private:
  Vector numbers_of(const Aiding& seen) const {
    if (!by_landmarks_) return seen.z;
    const Index d = seen.z.size() / std::ssize(seen.landmarks);
    Vector all = Vector::Constant(std::ssize(measurements), std::nan(""));
    for (std::size_t i = 0; i < seen.landmarks.size(); ++i) {
      all.segment(d * seen.landmarks[i], d) = seen.z.segment(d * static_cast<Index>(i), d);
    }
    return all;
  }

  std::shared_ptr<const Model> model_;
  ChartedWorld<Model> world_;
  PlugSettings settings_;
  bool by_landmarks_;
};

}  // namespace credence
