#include "analysis/studies/textbook_ekf.h"

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"

namespace credence::internal {

TextbookEkf::TextbookEkf(const PlanarModel& model, const Eigen::Matrix2d& Q, const Eigen::Matrix2d& R)
    : model_(model), Q_(Q), R_(R) {}

void TextbookEkf::reset(VectorRef x, MatrixRef P, std::span<const int> ids) {
  x_ = x;
  P_ = P;
  ids_.assign(ids.begin(), ids.end());
}

void TextbookEkf::predict(const Control& u) {
  const auto motion = model_.move(pose(), u);
  x_.head<3>() = motion.pose;
  P_.topRows<3>() = (motion.F * P_.topRows<3>()).eval();
  P_.leftCols<3>() = (P_.leftCols<3>() * motion.F.transpose()).eval();
  P_.topLeftCorner<3, 3>() += motion.G * Q_ * motion.G.transpose();
}

UpdateResult TextbookEkf::update(std::span<const Observation<PlanarModel>> observations) {
  UpdateResult result{.dof = 2 * std::ssize(observations), .trace_prior = P_.trace()};
  Matrix H = Matrix::Zero(result.dof, x_.size()), R = Matrix::Zero(result.dof, result.dof);
  Vector nu(result.dof);
  for (Index i = 0; i < result.dof; i += 2) {
    const Observation<PlanarModel>& o = observations[static_cast<std::size_t>(i / 2)];
    const Index offset = offset_of(o.landmark);
    const auto predicted = model_.predict(pose(), x_.segment<2>(offset));
    nu.segment<2>(i) = model_.innovation(o.z, predicted.z);
    H.block<2, 3>(i, 0) = predicted.H_r;
    H.block<2, 2>(i, offset) = predicted.H_l;
    R.block<2, 2>(i, i) = R_;
  }
  const Matrix PHt = P_ * H.transpose();
  const Matrix S = H * PHt + R;
  const Eigen::LLT<Matrix> factor(S);
  result.ok = factor.info() == Eigen::Success;
  if (!result.ok) return result;
  result.nis = nu.dot(factor.solve(nu));
  const Matrix K = factor.solve(PHt.transpose()).transpose();
  x_ += K * nu;
  Pose x_r = pose();
  model_.wrap_pose(x_r);
  x_.head<3>() = x_r;
  P_ -= K * PHt.transpose();
  P_ -= (P_ * H.transpose() - K * R) * K.transpose();
  symmetrise(P_);
  return result;
}

}  // namespace credence::internal
