#pragma once

#include <cstdint>

#include "core/types.h"
#include "montecarlo/random/noise.h"

namespace credence {

/// The random numbers of one step of one run and one purpose, one after the other: a pure function of seed,
/// run, step, purpose and the place in this order, whatever is drawn elsewhere, and by which thread.
class NoiseDraw {
 public:
  NoiseDraw(const NoiseSource& source, std::int64_t run, std::int64_t step, NoisePurpose purpose,
            std::int64_t first_slot = 0)
      : source_(&source), run_(run), step_(step), purpose_(purpose), slot_(first_slot) {}

  /// The next standard normal.
  double normal() { return source_->normal(run_, step_, purpose_, slot_++); }
  /// The next `count` standard normals.
  Vector normals(Index count) {
    Vector result(count);
    source_->normals(run_, step_, purpose_, {result.data(), static_cast<std::size_t>(count)}, slot_);
    slot_ += count;
    return result;
  }
  /// The next number uniform in [0, 1).
  double uniform() { return source_->uniform(run_, step_, purpose_, slot_++); }

 private:
  const NoiseSource* source_;
  std::int64_t run_, step_;
  NoisePurpose purpose_;
  std::int64_t slot_;
};

}  // namespace credence
