#pragma once

#include "core/filters/estimators/unscented_transform.h"
#include "montecarlo/worlds/plugged/model_plug.h"

namespace credence {

/// The unscented Kalman filter of a model with additive noise ([Julier 2004]; [Särkkä 2013], algorithm 5.14):
/// sigma points of P pass through f, and those of the predicted P through h.
class FunctionUkf : public FunctionFilter {
 public:
  /// `spread` is α: sigma points lie α √n standard deviations away. Throws as FunctionWorld does.
  explicit FunctionUkf(const FunctionModel& model, double spread = 1.0);

  void predict();
  /// False where S is not positive definite.
  bool update(const Vector& z);

 private:
  double spread_;
  internal::UnscentedTransform points_;
};

}  // namespace credence
