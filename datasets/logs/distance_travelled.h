#pragma once

#include "core/types.h"

namespace credence::internal {

/// The distance that a truth has travelled since its first place.
class DistanceTravelled {
 public:
  /// Up to this place, of any dimension, but the same each time; m.
  double at(const Eigen::Ref<const Vector>& place) {
    if (last_.size() > 0) travelled_m_ += (place - last_).norm();
    last_ = place;
    return travelled_m_;
  }

 private:
  Vector last_;
  double travelled_m_ = 0.0;
};

}  // namespace credence::internal
