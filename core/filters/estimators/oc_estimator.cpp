#include "core/filters/estimators/oc_estimator.h"

#include "core/manifold/rotation.h"

namespace credence {

void OcEstimator::linearise(const PlanarTruth&) {
  Eigen::Matrix<double, 2, 3> H_r;
  Eigen::Matrix2d H_l;
  for (std::size_t i = 0; i < seen_z().size(); ++i) {
    const Index offset = seen()[3 + 2 * i];
    const Point l = landmark(offset);
    plane_jacobian(pose(), l, H_r, H_l);
    const Eigen::Vector2d d = first_landmark(offset) - first_pose().head<2>();
    const Eigen::Vector2d turn = 0.5 * quarter_turn(d);
    const Eigen::Vector3d u_r(-turn[0], -turn[1], 1.0);
    const Eigen::Vector2d told = (H_r * u_r + H_l * turn) / (1.0 + 2.0 * turn.squaredNorm());
    H_r -= told * u_r.transpose();
    H_l -= told * turn.transpose();
    set_rows(static_cast<Index>(i), innovation_of(i, pose(), l), H_r, H_l);
  }
}

}  // namespace credence
