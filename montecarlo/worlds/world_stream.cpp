#include "montecarlo/worlds/world_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "montecarlo/worlds/registry.h"

namespace credence {
namespace {

/// Worlds whose experiment shows a measurement as one vector, and where nothing is steered.
class ExperimentStream final : public WorldStream {
 public:
  explicit ExperimentStream(std::unique_ptr<Experiment> experiment) : experiment_(std::move(experiment)) {
    states = experiment_->layout().states;
    Index most = 0;
    experiment_->visit(0, [&](const TraceStep& now) { most = std::max(most, now.z.size()); });
    for (Index i = 1; i <= most; ++i) measurements.push_back(std::to_string(i));
  }

  void visit(std::int64_t run,
             const std::function<void(std::int64_t, const StreamRow&)>& take) const override {
    experiment_->visit(run, [&](const TraceStep& now) {
      StreamRow row{.truth = now.truth};
      (now.step == 0 ? row.prior : row.measurement) = now.step == 0 ? now.estimate : now.z;
      take(now.step, row);
    });
  }

 private:
  std::unique_ptr<Experiment> experiment_;
};

}  // namespace

std::vector<std::string> names_of_landmarks(std::size_t count, const std::vector<std::string>& numbers) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= count; ++i) {
    for (const std::string& number : numbers) names.push_back(fmt::format("landmark{}.{}", i, number));
  }
  return names;
}

std::unique_ptr<const WorldStream> world_stream(const Scenario& scenario) {
  const World& world = world_of(scenario);
  if (world.stream != nullptr) return world.stream(scenario);
  auto stream = std::make_unique<ExperimentStream>(make_experiment(scenario));
  if (stream->measurements.empty()) {
    throw std::invalid_argument(
        fmt::format("{}: what is measured there is not told; it is of all worlds but the spatial one",
                    world_text(scenario)));
  }
  return stream;
}

}  // namespace credence
