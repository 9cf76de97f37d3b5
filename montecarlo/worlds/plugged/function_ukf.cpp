#include "montecarlo/worlds/plugged/function_ukf.h"

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"

namespace credence {

using namespace internal;

FunctionUkf::FunctionUkf(const FunctionModel& model, double spread)
    : FunctionFilter(model), spread_(spread) {}

void FunctionUkf::predict() {
  const Vector moved = model_.f(x_);
  points_.take(P_, x_.size(), spread_, [&](const VectorRef& step, Eigen::Ref<Vector> y) {
    Vector change = model_.f(x_ + step) - moved;
    wrap_angles(change, state_angles_);
    y = change;
  });
  x_ = moved + points_.shift();
  wrap_angles(x_, state_angles_);
  P_ = points_.D() * points_.D().transpose() + points_.curvature() + model_.Q;
  symmetrise(P_);
}

bool FunctionUkf::update(const Vector& z) {
  const Vector expected = model_.h(x_);
  points_.take(P_, z.size(), spread_, [&](const VectorRef& step, Eigen::Ref<Vector> y) {
    Vector change = model_.h(x_ + step) - expected;
    wrap_angles(change, model_.measured_angles);
    y = change;
  });
  nu_ = z - expected - points_.shift();
  wrap_angles(nu_, model_.measured_angles);
  S_ = points_.D() * points_.D().transpose() + points_.curvature() + model_.R;
  symmetrise(S_);
  const Eigen::LLT<Matrix> factor(S_);
  if (factor.info() != Eigen::Success) return false;
  const Matrix of_cross = points_.D() * points_.root().transpose();  // m×n
  const Matrix K = factor.solve(of_cross).transpose();
  x_ += K * nu_;
  wrap_angles(x_, state_angles_);
  P_ -= K * S_ * K.transpose();
  symmetrise(P_);
  return true;
}

}  // namespace credence
