#pragma once

#include "core/filters/estimators/ekf_estimator.h"

namespace credence {

/// Iterated EKF: the correction is the minimum of the quadratic prior and the measurements' squares by
/// Gauss-Newton ([Bell 1993]), H and ν at its end; ν = z − h(x_i) − H_i (x̂ − x_i).
class IteratedEstimator final : public EkfEstimator {
 public:
  static constexpr int kMostIterations = 10;

  using EkfEstimator::EkfEstimator;

 private:
  void linearise(const PlanarTruth& truth) override;

  MatrixBuffer prior_, change_, next_, at_, PHt_, S_, solved_;
};

}  // namespace credence
