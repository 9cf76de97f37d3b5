#pragma once

#include <span>
#include <vector>

#include "analysis/laws/consistency_vector_moments.h"
#include "analysis/laws/coverage.h"
#include "analysis/laws/whiteness.h"
#include "analysis/studies/selftest_filter.h"
#include "montecarlo/engine/moments.h"

namespace credence {

/// What a study of a synthetic filter leaves for the tests.
struct SyntheticStudy {
  using PerStep = std::vector<Moments>;
  using Block = std::vector<SyntheticFilter::Sample>;

  PerStep nees, heading_nees, landmark_nees, nis;
  PerStep gated_nis;  ///< of the NIS within the gate
  std::vector<double> nis_values, gated_nis_values;
  std::vector<CoverageCount> coverage;  ///< of the 2σ region, at each step
  Moments run_sum_nees;                 ///< over runs: NEES summed over the steps
  std::vector<double> last_nees;        ///< of each run, at the last step
  std::vector<Vector> last_errors;      ///< of each run, at the last step
  VectorMoments last_whitened;          ///< over runs: the whitened error at the last step
  VectorMoments innovation;             ///< normalised
  VectorMoments run_mean_innovation;    ///< averaged over each run
  std::int64_t beyond_half_turn = 0;    ///< compass innovations outside [−π, π]
  std::vector<Block> blocks;
};

/// The gate of gated innovations: the 95 % quantile of their law.
double synthetic_gate();

/// The study of the runs of these blocks.
SyntheticStudy make_study(const SyntheticFilter& filter, const NoiseSource& noise, std::int64_t first_block,
                          int blocks);

/// NEES and NIS alone, which is all that many studies need: added to the moments of each step.
void add_samples(const SyntheticFilter& filter, std::span<const SyntheticFilter::Sample> samples,
                 std::vector<Moments>& nees, std::vector<Moments>& nis);

/// The products of normalised innovations from this step on, of gated ones those that passed.
LagProducts synthetic_lags(const SyntheticFilter& filter, const SyntheticStudy& study, int first_step);

/// `dof` of one value, summed over those of each step.
std::vector<double> synthetic_dofs(const std::vector<Moments>& steps, double dof);

}  // namespace credence
