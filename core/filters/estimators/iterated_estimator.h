#pragma once

#include "core/filters/estimators/ekf_estimator.h"

namespace credence::internal {

/// Iterated EKF: the correction is the minimum of the quadratic prior and the measurements' squares by
/// Gauss-Newton ([Bell 1993]), H and ν at its end; ν = z − h(x_i) − H_i (x̂ − x_i).
///
/// It has settled once a step is below 1e-10 m and rad, mostly after a few. From the eleventh on a step is
/// halved as long as the sum of the squares is larger behind it; after kMostIterations the correction is
/// where they led, and UpdateResult::converged is false.
class IteratedEstimator final : public EkfEstimator {
 public:
  static constexpr int kPlainIterations = 10, kMostIterations = 200;

  using EkfEstimator::EkfEstimator;

 private:
  void linearise(const PlanarTruth& truth) override;

  /// dᵀ P⁻¹ d + Σ νᵀ R⁻¹ ν at the present change d, with P⁻¹ d its dual: P may be singular. NaN or infinite
  /// where R is.
  double cost();
  /// From the present change towards the next one, but not to a larger cost.
  void shorten_step();

  MatrixBuffer prior_, change_, next_, at_, PHt_, S_, solved_, dual_, next_dual_;
};

}  // namespace credence::internal
