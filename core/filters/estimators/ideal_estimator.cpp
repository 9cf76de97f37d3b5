#include "core/filters/estimators/ideal_estimator.h"

#include "core/manifold/rotation.h"

namespace credence {

void IdealEstimator::propagate(const Pose&, const Motion&, const Control& u, const PlanarTruth& truth) {
  const auto G = settings().model.move(truth.before, u).G;
  propagate_pose(plane_motion(truth.before.head<2>(), truth.now.head<2>()), G * settings().Q * G.transpose());
}

void IdealEstimator::linearise(const PlanarTruth& truth) {
  Jacobian H_r;
  Eigen::Matrix2d H_l;
  for (std::size_t i = 0; i < seen_z().size(); ++i) {
    const Index offset = seen()[3 + 2 * i];
    plane_jacobian(truth.now, truth.landmarks[static_cast<std::size_t>(number_at(offset))], H_r, H_l);
    set_rows(static_cast<Index>(i), innovation_of(i, pose(), landmark(offset)), H_r, H_l);
  }
}

void IdealEstimator::place(const Eigen::Vector2d&, const PlanarTruth& truth, Jacobian& J_r,
                           Eigen::Matrix2d& J_z) {
  const Point& l = truth.landmarks[static_cast<std::size_t>(number_at(size() - 2))];
  const Eigen::Vector2d away = l - truth.now.head<2>();
  const Eigen::Matrix2d R = rotation(truth.now[2]);
  J_r << Eigen::Matrix2d::Identity(), quarter_turn(away);
  J_z = R * settings().sensor.inverse_jacobian(settings().sensor.measure(R.transpose() * away));
}

}  // namespace credence
