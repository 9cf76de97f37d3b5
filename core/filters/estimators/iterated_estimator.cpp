#include "core/filters/estimators/iterated_estimator.h"

#include "core/linear_algebra/cholesky.h"

namespace credence::internal {

void IteratedEstimator::linearise(const PlanarTruth&) {
  constexpr double kSettled = 1e-10;  // m, rad
  const auto s = static_cast<Index>(seen().size()), m = s - 3;
  auto prior = prior_.resize(s), change = change_.resize(s), next = next_.resize(s), at = at_.resize(s);
  for (Index j = 0; j < s; ++j) prior(j) = x()[seen()[static_cast<std::size_t>(j)]];
  const auto P_seen = seen_covariance();
  auto PHt = PHt_.resize(s, m), S = S_.resize(m, m), solved = solved_.resize(m);
  auto dual = dual_.resize(s), next_dual = next_dual_.resize(s);
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
    next_dual = H().transpose().lazyProduct(solved);
    const double moved = (next - change).cwiseAbs().maxCoeff();
    if (iteration >= kPlainIterations) {
      shorten_step();
    } else {
      change = next;
      dual = next_dual;
    }
    if (!(moved > kSettled)) return;
  }
  set_not_converged();
}

double IteratedEstimator::cost() {
  auto change = change_.matrix(), at = at_.matrix(), dual = dual_.matrix();
  at = prior_.matrix() + change;
  const Eigen::LLT<Eigen::Matrix2d> R(settings().R);
  double cost = dual.col(0).dot(change.col(0));
  for (Index i = 0; 3 + 2 * i < at.rows(); ++i) {
    const Point l(at.middleRows<2>(3 + 2 * i));
    const Eigen::Vector2d nu = innovation_of(static_cast<std::size_t>(i), Pose(at.topRows<3>()), l);
    cost += nu.dot(R.solve(nu));
  }
  return cost;
}

void IteratedEstimator::shorten_step() {
  constexpr double kRounding = 1e-12, kShortest = 1e-3;
  auto change = change_.matrix(), next = next_.matrix(), dual = dual_.matrix(),
       next_dual = next_dual_.matrix();
  const double before = cost();
  // From here on the step is what is left to go from `next`.
  next -= change;
  next_dual -= dual;
  change += next;
  dual += next_dual;
  for (double share = 1.0; share > kShortest && cost() > before * (1.0 + kRounding); share *= 0.5) {
    change -= 0.5 * share * next;
    dual -= 0.5 * share * next_dual;
  }
}

}  // namespace credence::internal
