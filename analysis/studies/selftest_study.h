#pragma once

#include <span>
#include <vector>

#include "analysis/calibration/calibration_sums.h"
#include "analysis/evidence/sums/evidence.h"
#include "analysis/studies/selftest_filter.h"

namespace credence::internal {

/// The evidence of the first `runs` runs from block `first_block` on, collected as of any other filter; run i
/// is of filter i modulo their number, so that P differs between runs if there are several. A filter with one
/// dof too many claims a state of variance one that has no error; one that logs what passed its gate logs
/// nothing else. The filters must have the same defect and assume the same R. calibration: is shown the same
/// rows.
Evidence synthetic_evidence(std::span<const SyntheticFilter> filters, const NoiseSource& noise,
                            std::int64_t first_block, int runs, int steps = SyntheticFilter::kSteps,
                            CalibrationRecorder* calibration = nullptr);
/// Of one filter.
Evidence synthetic_evidence(const SyntheticFilter& filter, const NoiseSource& noise, std::int64_t first_block,
                            int runs, int steps = SyntheticFilter::kSteps,
                            CalibrationRecorder* calibration = nullptr);

/// NEES and NIS alone, which is all that many studies need: added to the moments of each step.
void add_samples(const SyntheticFilter& filter, std::span<const SyntheticFilter::Sample> samples,
                 std::vector<Moments>& nees, std::vector<Moments>& nis);

/// `dof` of one value, summed over those of each step.
std::vector<double> synthetic_dofs(const std::vector<Moments>& steps, double dof);

}  // namespace credence::internal
