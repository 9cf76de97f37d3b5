#pragma once

#include <vector>

#include "analysis/tuning/noise_parameters.h"

namespace credence::internal {

/// What one step of a Kalman filter and its derivatives by φ do to data, beside the data.
///
///   u = S⁻¹ν,  x̂⁺ = F x̂ + F K ν,  ẋ̂⁺ = F (I − K H) ẋ̂ + F K̇ ν,  ν̇ = −H ẋ̂   (x̂ = x̂_{k|k−1})
struct InnovationStep {
  Matrix S_inverse, S_root_inverse;  ///< m×m; the latter L⁻¹, S = L Lᵀ
  double log_determinant = 0.0;      ///< of S
  Matrix FK;                         ///< n×m
  Matrix closed;                     ///< F (I − K H), n×n
  Matrix FK_dot;                     ///< F K̇_i below each other, (n p)×m
  std::vector<Matrix> S_dot;         ///< Ṡ_i, m×m
  Vector trace;                      ///< tr(S⁻¹ Ṡ_i)
};

/// The steps of a filter, which depend on no data. Once the covariance and its derivatives have settled to
/// rounding the last step stands for all that follow.
class InnovationSensitivities {
 public:
  /// P ← F (P − K S Kᵀ) Fᵀ + G Q Gᵀ from P0 on, differentiated: as K makes the trace of the update least,
  /// Ṗ⁺ = (I − K H) Ṗ (I − K H)ᵀ + K Ṙ Kᵀ has no term of K̇ ([Mehra 1970]; the adjoint-free form of the
  /// score in sensitivity equations). `derivatives` may be empty: then there are no derivatives.
  /// Cost (steps until settled) × (1 + p) × n³.
  InnovationSensitivities(const LinearModel& model, std::vector<NoiseDerivative> derivatives, Index steps);

  /// False: S was not positive definite at some step.
  bool ok() const { return ok_; }
  const InnovationStep& step(Index k) const {
    return steps_[static_cast<std::size_t>(std::min(k, std::ssize(steps_) - 1))];
  }
  Index parameters() const { return parameters_; }

  /// The expected information of one run of so many steps if the model is true: Σ_k ½ tr(S⁻¹Ṡ_i S⁻¹Ṡ_j) +
  /// E[ν̇_iᵀ S⁻¹ ν̇_j], the mean from the covariance of the ẋ̂_i, which white ν drive. p×p. Cost
  /// steps × (n p)³ until that covariance has settled.
  Matrix expected_information(Index steps) const;

 private:
  bool add_step(const LinearModel& model, const std::vector<NoiseDerivative>& derivatives, Matrix& P,
                std::vector<Matrix>& P_dot);

  Matrix H_;
  Index parameters_;
  std::vector<InnovationStep> steps_;
  std::vector<Matrix> S_;
  bool ok_ = true;
};

}  // namespace credence::internal
