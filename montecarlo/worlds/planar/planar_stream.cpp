#include "montecarlo/worlds/planar/planar_stream.h"

#include <cmath>

#include "montecarlo/scenario/noise_switches.h"

namespace credence {

PlanarStream::PlanarStream(const Scenario& scenario)
    : world_(make_planar_world(scenario)),
      noise_(PlanarNoise::of(scenario)),
      source_(noise_source(scenario)) {
  states = {"vehicle.x", "vehicle.y", "vehicle.heading"};
  inputs = {"1", "2"};
  measurements = names_of_landmarks(world_.landmarks.size(), {"range", "bearing"});
  notes = text_of_landmarks(world_.landmarks);
}

void PlanarStream::visit(std::int64_t run,
                         const std::function<void(std::int64_t, const StreamRow&)>& take) const {
  PlanarDrive drive(world_, noise_, source_);
  const Pose prior = drive.start(run);
  take(0, {.prior = prior, .truth = drive.pose()});
  for (std::size_t k = 1; k <= world_.controls.size(); ++k) {
    drive.move(k);
    take(static_cast<std::int64_t>(k),
         {.truth = drive.pose(),
          .input = world_.controls[k - 1],
          .measurement = numbers_of_observations(drive.observe(k), world_.landmarks.size())});
  }
}

Vector numbers_of_observations(std::span<const Observation<PlanarModel>> seen, std::size_t landmarks) {
  if (seen.empty()) return {};
  Vector z = Vector::Constant(static_cast<Index>(2 * landmarks), std::nan(""));
  for (const auto& observation : seen) z.segment<2>(2 * Index{observation.landmark}) = observation.z;
  return z;
}

}  // namespace credence
