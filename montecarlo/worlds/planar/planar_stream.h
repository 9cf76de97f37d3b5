#pragma once

#include <span>

#include "montecarlo/random/noise.h"
#include "montecarlo/worlds/planar/planar_drive.h"
#include "montecarlo/worlds/world_stream.h"

namespace credence {

/// A vehicle in the plane: nominal controls, and range (m) and bearing (rad) of the landmarks in view.
class PlanarStream final : public WorldStream {
 public:
  /// Throws as make_planar_world does.
  explicit PlanarStream(const Scenario& scenario);
  void visit(std::int64_t run,
             const std::function<void(std::int64_t, const StreamRow&)>& take) const override;

 private:
  PlanarWorld world_;
  PlanarNoise noise_;
  NoiseSource source_;
};

/// Each at the numbers of its landmark; empty where nothing is seen.
Vector numbers_of_observations(std::span<const Observation<PlanarModel>> seen, std::size_t landmarks);

}  // namespace credence
