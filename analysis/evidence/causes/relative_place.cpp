#include "analysis/evidence/causes/relative_place.h"

#include "core/manifold/trigonometry.h"

namespace credence::internal {

RelativePlace::RelativePlace(const State& x, double sine_of_x, double cosine_of_x)
    : sine(sine_of_x), cosine(cosine_of_x) {
  const Eigen::Vector2d d = x.tail<2>() - x.head<2>();
  r = {cosine * d[0] + sine * d[1], cosine * d[1] - sine * d[0]};
}

RelativePlace::RelativePlace(const State& x) {
  const auto [s, c] = sine_cosine(x[2]);
  *this = RelativePlace(x, s, c);
}

Eigen::Matrix<double, 2, 5> RelativePlace::jacobian() const {
  return Eigen::Matrix<double, 2, 5>{{-cosine, -sine, r[1], cosine, sine},
                                     {sine, -cosine, -r[0], -sine, cosine}};
}

Eigen::Matrix2d RelativePlace::covariance(const Covariance& P) const {
  const Eigen::Matrix<double, 2, 5> J = jacobian();
  return J * P * J.transpose();
}

}  // namespace credence::internal
