#include "montecarlo/worlds/world_stream.h"

#include <fmt/format.h>

#include <memory>
#include <stdexcept>
#include <utility>

#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

/// Of worlds whose experiment shows a measurement as one vector, and where nothing is steered.
WorldStream stream_of(std::shared_ptr<const Experiment> experiment) {
  WorldStream stream{.states = experiment->layout().states, .measurements = {}, .visit = {}};
  // Not of a run: it may be one in which nothing is measured.
  for (const Sensor& sensor : experiment->layout().sensors) {
    for (Index i = 1; i <= sensor.dim; ++i) stream.measurements.push_back(std::to_string(i));
  }
  if (const std::string no_pose = no_pose_sentence(experiment->layout()); !no_pose.empty())
    stream.notes = no_pose + "\n";
  stream.visit = [experiment = std::move(experiment)](std::int64_t run, const RowVisitor& take) {
    std::int64_t step = 0;
    const Outcome outcome = experiment->visit(run, [&](const TraceStep& now) {
      step = now.step;
      if (now.outcome != Outcome::ok) return;  // what is left there is of the step before
      StreamRow row{.truth = now.truth};
      (now.step == 0 ? row.prior : row.measurement) = now.step == 0 ? now.estimate : now.z;
      take(now.step, row);
    });
    if (outcome == Outcome::ok) return;
    throw std::invalid_argument(
        fmt::format("run {} ends at step {}, where the filter of the scenario fails ({})", run, step,
                    to_string(outcome)));
  };
  return stream;
}

}  // namespace

std::vector<std::string> names_of_landmarks(std::size_t count, const std::vector<std::string>& numbers) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= count; ++i) {
    for (const std::string& number : numbers) names.push_back(fmt::format("landmark{}.{}", i, number));
  }
  return names;
}

WorldStream world_stream(const Scenario& scenario) {
  const World& world = world_of(scenario);
  if (world.stream != nullptr) return world.stream(scenario);
  WorldStream stream = stream_of(make_experiment(scenario));
  if (stream.measurements.empty()) {
    throw std::invalid_argument(fmt::format("{}: what is measured there is not told", world_text(scenario)));
  }
  return stream;
}

}  // namespace credence::internal
