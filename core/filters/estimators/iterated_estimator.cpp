#include "core/filters/estimators/iterated_estimator.h"

#include "core/linear_algebra/cholesky.h"
#include "core/manifold/angle.h"

namespace credence {

void IteratedEstimator::linearise(const PlanarTruth&) {
  constexpr double kSettled = 1e-10;  // m, rad
  const auto s = static_cast<Index>(seen().size()), m = s - 3;
  auto prior = prior_.resize(s), change = change_.resize(s), next = next_.resize(s), at = at_.resize(s);
  for (Index j = 0; j < s; ++j) prior(j) = x()[seen()[static_cast<std::size_t>(j)]];
  const auto P_seen = seen_covariance();
  auto PHt = PHt_.resize(s, m), S = S_.resize(m, m), solved = solved_.resize(m);
  change.setZero();  // x_i − x̂
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    at = prior + change;
    const Pose pose_at(at.topRows<3>());
    Jacobian H_r;
    Eigen::Matrix2d H_l;
    for (Index i = 0; 2 * i < m; ++i) {
      const Point l(at.middleRows<2>(3 + 2 * i));
      plane_jacobian(pose_at, l, H_r, H_l);
      const Eigen::Vector2d nu = innovation_of(static_cast<std::size_t>(i), pose_at, l);
      set_rows(i, nu + H_r * change.topRows<3>() + H_l * change.middleRows<2>(3 + 2 * i), H_r, H_l);
    }
    PHt = P_seen.lazyProduct(H().transpose());
    S = H().lazyProduct(PHt);
    for (Index i = 0; i < m; i += 2) S.block<2, 2>(i, i) += settings().R;
    const Eigen::LLT<Eigen::Ref<Matrix>> llt(S);
    if (llt.info() != Eigen::Success) return;  // the correction will see it
    solved = nu();
    llt.solveInPlace(solved);
    next = PHt.lazyProduct(solved);
    const double moved = (next - change).cwiseAbs().maxCoeff();
    change = next;
    if (!(moved > kSettled)) return;
  }
}

}  // namespace credence
