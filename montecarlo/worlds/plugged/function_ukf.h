#pragma once

#include "core/filters/estimators/unscented_transform.h"
#include "montecarlo/worlds/plugged/model_plug.h"

namespace credence {

/// The unscented Kalman filter of a model with additive noise ([Julier 2004]; [Särkkä 2013], algorithm 5.14):
/// sigma points of P pass through f, and those of the predicted P through h.
class FunctionUkf {
 public:
  /// `spread` is α: sigma points lie α √n standard deviations away. Throws as FunctionWorld does.
  explicit FunctionUkf(const FunctionModel& model, double spread = 1.0);

  void reset(const Vector& mean, const Matrix& P);
  void predict();
  /// False where S is not positive definite.
  bool update(const Vector& z);

  const Vector& state() const { return x_; }
  const Matrix& covariance() const { return P_; }
  const Vector& innovation() const { return nu_; }
  const Matrix& innovation_covariance() const { return S_; }

 private:
  FunctionModel model_;
  std::vector<bool> state_angles_;
  double spread_;
  UnscentedTransform points_;
  Vector x_, nu_;
  Matrix P_, S_;
};

}  // namespace credence
