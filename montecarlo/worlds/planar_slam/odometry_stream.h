#pragma once

#include "montecarlo/random/noise.h"
#include "montecarlo/worlds/planar_slam/odometry_world.h"
#include "montecarlo/worlds/world_stream.h"

namespace credence {

/// A vehicle whose odometry is read with noise, and what its sensor says of the landmarks in view: their
/// relative positions (m), or range (m) and bearing (rad).
class OdometryStream final : public WorldStream {
 public:
  /// Throws as make_odometry_world does.
  explicit OdometryStream(const Scenario& scenario);
  void visit(std::int64_t run,
             const std::function<void(std::int64_t, const StreamRow&)>& take) const override;

 private:
  OdometryWorld world_;
  NoiseSource source_;
};

}  // namespace credence
