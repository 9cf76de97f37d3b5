#pragma once

#include <cstdint>
#include <memory>

/// @file
/// What a study of a given size can see, and the size it needs: the power of the verdicts of consistency.h
/// against a covariance that is wrong by a factor.
///
/// factor = true covariance / claimed P: above 1 the filter is optimistic, below 1 pessimistic. The sum of
/// the statistic is then factor · χ², so that the power of each test is exact.

namespace credence::internal {

class SimulatedStudies;

/// The study whose verdict is planned.
struct VerdictDesign {
  double steps = 1.0;         ///< T
  double dof_per_step = 1.0;  ///< of one run: n for NEES, m for NIS
  double confidence = 0.95;
  bool white = false;            ///< true: judge_nis; false: judge_nees
  double effective_steps = 1.0;  ///< for NEES: independent steps (effective_sample.h); 1 is fully correlated
  double run_skewness = 0.0;     ///< for NEES: of the average of a run; 0: that of a multiple of χ²
  double least_dof = 0.0;        ///< for NEES: of any step of a run; 0: dof_per_step
  /// For NEES, of `simulated`: by which the power of whole runs and the width of the interval are found;
  /// null: by averages that vary as they do on average, which of few runs find more than the verdict does.
  std::shared_ptr<SimulatedStudies> studies{};
};

/// The design with so many studies that are simulated by its own numbers, for one thread.
VerdictDesign simulated(VerdictDesign design, int studies);

/// Power of judge_nis or judge_nees over `runs` runs: the larger of the powers of its two parts, which is a
/// lower bound of the power of both.
///
/// Sum over white steps: exact. Correlated steps: of 5 to 200 runs in simulated studies, where the design has
/// them, judged as the verdict does, their averages gamma but for a shift; else by the interval of averages
/// that vary as they do on average, their mean a multiple of χ² with the effective dof; of fewer than five by
/// the bound for every dependence. Steps: exact for white ones; one
/// step at the Bonferroni level for correlated ones. Throws std::invalid_argument unless factor > 0 and runs
/// > 0, and for an impossible design.
double verdict_power(const VerdictDesign& design, double factor, double runs);

/// An answer of planning.
struct RunsNeeded {
  std::int64_t runs = 0;
  double power = 0.0;  ///< achieved with these runs
};

/// The fewest runs with which the verdict detects the factor with at least this power. Throws
/// std::invalid_argument for factor = 1 (nothing to detect) or not > 0, power outside (0, 1), an impossible
/// design, or a factor so near 1 that more than 10¹² runs are needed.
RunsNeeded runs_to_detect(const VerdictDesign& design, double factor, double power);

/// The factors nearest to 1, below and above, that `runs` runs detect with this power.
struct DetectableFactors {
  double below = 0.0;
  double above = 0.0;
};
DetectableFactors detectable_factors(const VerdictDesign& design, double runs, double power);

/// The fewest runs, at least 2, whose interval of the mean NEES of a consistent filter (run_mean_interval)
/// has at most this relative half-width on average, over simulated studies of up to 200 runs, else where the
/// averages of the runs vary as they do on average: of many runs z² 2 / (n T_eff precision²). Throws
/// std::invalid_argument unless precision > 0.
std::int64_t runs_for_precision(const VerdictDesign& design, double precision);

}  // namespace credence::internal
