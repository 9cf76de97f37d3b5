#pragma once

#include <vector>

#include "core/filters/estimators/ekf_estimator.h"

namespace credence::internal {

/// Schmidt's consider filter ([Schmidt 1966]): an EKF that places a landmark at its first
/// observation, estimates it at `active_sights` more, and from the next on only considers it. Its place and
/// variance stay what they are; its correlations with all that is estimated go on, so that the pose is not
/// made more certain than the map allows. Where P_aa is of what is estimated and P_cc of what is considered,
///
///   K = [P_aa, P_ac] Hᵀ S⁻¹ with zeros for c,   P_aa ← P_aa − K_a S K_aᵀ,   P_ac ← P_ac − K_a H P_c,   P_cc
///   ← P_cc.
class SchmidtEstimator final : public EkfEstimator {
 public:
  explicit SchmidtEstimator(const EstimatorSettings& settings);

 private:
  void started() override;
  void linearise(const PlanarTruth& truth) override;
  void apply(Eigen::Map<Matrix>& W, Eigen::Map<Vector>& delta) override;

  bool is_considered(Index state) const {
    return state >= 3 && observations_[static_cast<std::size_t>(state - 3) / 2] > settings().active_sights;
  }

  std::vector<Index> observations_;  ///< of the landmarks in the order of the state, after the first
};

}  // namespace credence::internal
