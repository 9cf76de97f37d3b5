#include "analysis/evidence/causes/relative_place.h"

#include "core/manifold/trigonometry.h"

namespace credence::internal {

RelativePlace relative_place(const RelativePlace::State& x) {
  const auto [s, c] = sine_cosine(x[2]);
  const Eigen::Matrix2d back{{c, s}, {-s, c}};
  RelativePlace place;
  place.r = back * (x.tail<2>() - x.head<2>());
  place.J << -back, Eigen::Vector2d(place.r[1], -place.r[0]), back;
  return place;
}

}  // namespace credence::internal
