#include "core/filters/estimators/ideal_estimator.h"

#include "core/manifold/rotation.h"

namespace credence::internal {

void IdealEstimator::propagate(const Pose&, const Motion&, const Control& u, const PlanarTruth& truth) {
  const auto G = settings().model.move(truth.before, u).G;
  propagate_pose(plane_motion(truth.before.head<2>(), truth.now.head<2>()), G * settings().Q * G.transpose());
}

void IdealEstimator::linearise(const PlanarTruth& truth) {
  set_plane_rows(truth.now,
                 [&](Index offset) { return truth.landmarks[static_cast<std::size_t>(number_at(offset))]; });
}

void IdealEstimator::place(const Eigen::Vector2d&, const PlanarTruth& truth, Jacobian& J_r,
                           Eigen::Matrix2d& J_z) {
  const Point& l = truth.landmarks[static_cast<std::size_t>(number_at(size() - 2))];
  const Eigen::Vector2d away = l - truth.now.head<2>();
  const Eigen::Matrix2d R = rotation(truth.now[2]);
  J_r << Eigen::Matrix2d::Identity(), quarter_turn(away);
  J_z = R * settings().sensor.inverse_jacobian(settings().sensor.measure(R.transpose() * away));
}

}  // namespace credence::internal
