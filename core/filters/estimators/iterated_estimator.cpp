#include "core/filters/estimators/iterated_estimator.h"

#include "core/linear_algebra/cholesky.h"
#include "core/manifold/angle.h"

namespace credence {

void IteratedEstimator::linearise(const PlanarTruth&) {
  constexpr double kSettled = 1e-10;  // m, rad
  const auto s = static_cast<Index>(seen().size()), m = s - 3;
  Vector prior(s);
  for (Index j = 0; j < s; ++j) prior[j] = x()[seen()[static_cast<std::size_t>(j)]];
  const auto P_seen = seen_covariance();
  Vector change = Vector::Zero(s);  // x_i − x̂
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const Vector at = prior + change;
    Jacobian H_r;
    Eigen::Matrix2d H_l;
    for (Index i = 0; 2 * i < m; ++i) {
      const Point l = at.segment<2>(3 + 2 * i);
      plane_jacobian(at.head<3>(), l, H_r, H_l);
      const Eigen::Vector2d nu = innovation_of(static_cast<std::size_t>(i), at.head<3>(), l);
      set_rows(i, nu + H_r * change.head<3>() + H_l * change.segment<2>(3 + 2 * i), H_r, H_l);
    }
    const Matrix PHt = P_seen * H().transpose();
    S_ = H() * PHt;
    for (Index i = 0; i < m; i += 2) S_.block<2, 2>(i, i) += settings().R;
    const Eigen::LLT<Matrix> llt(S_);
    if (llt.info() != Eigen::Success) return;  // the correction will see it
    const Vector next = PHt * llt.solve(Vector(nu()));
    const double moved = (next - change).cwiseAbs().maxCoeff();
    change = next;
    if (!(moved > kSettled)) return;
  }
}

}  // namespace credence
