#pragma once

#include <span>
#include <vector>

#include "analysis/evidence/consistency.h"
#include "core/types.h"

namespace credence {

/// The joint law of the tests of all steps and of their sum, for a known correlation of NEES between steps.
struct CorrelatedSteps {
  Matrix correlation;                  ///< between the steps with dof > 0, in their order
  std::vector<double> dofs;            ///< total dof of these steps
  std::vector<double> largest_scores;  ///< draws of the largest |normal score| under consistency, ascending
};

/// Draws that law: 20,000 draws from N(0, correlation) with a fixed seed, so the same input gives the same
/// bits.
///
/// correlation: T×T over the steps given, symmetric with a unit diagonal for steps with dof > 0; exact from
/// linear_nees_time_law, or empirical from empirical_nees_time_law. Cost 20,000 T². Throws
/// std::invalid_argument for another size or an entry outside [−1, 1].
CorrelatedSteps correlated_steps(MatrixRef correlation, std::span<const double> total_dof_per_step);

/// The verdict on NEES when its correlation between steps is known: sharper than judge_nees, which holds for
/// any.
///
/// Every step and the sum over steps are tested together by their largest normal score; the smallest p-value
/// is 1/20,001. The sum is a multiple of χ² with the variance that the correlation implies. Approximate:
/// normal scores of sums over runs are jointly normal only for many runs (count × dof of a step from about
/// 30), and an empirical correlation needs about 50 runs. Throws as judge_nees, and if the steps with data
/// are not those of `steps` (then draw their law anew).
ConsistencyVerdict judge_correlated_nees(std::span<const Moments> per_step,
                                         std::span<const double> total_dof_per_step,
                                         const CorrelatedSteps& steps, double confidence);

}  // namespace credence
