#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/inflation/inflation_rule.h"
#include "core/models/linear_model.h"
#include "core/simd/aligned_vector.h"
#include "montecarlo/engine/study_statistics.h"
#include "montecarlo/lanes/intermittent_kernel.h"
#include "montecarlo/random/noise.h"

namespace credence::internal {

/// A linear world whose measurements may be missed at random, and the filter in it.
struct IntermittentProblem {
  LinearModel truth;    ///< makes the noise
  LinearModel assumed;  ///< what the filter believes
  InflationRule rule;
  double detection_probability = 1.0;  ///< of every measurement at every step, independently
  Index measurement_delay = 0;         ///< steps after which a measurement reaches the filter
  /// Of the steps 2 … p of a period; empty: the same always.
  std::vector<LinearModel> truth_later{}, assumed_later{};

  bool is_periodic() const { return !truth_later.empty(); }
  /// Of all steps of a period, which may be a single one.
  std::vector<LinearModel> truth_period() const;
  std::vector<LinearModel> assumed_period() const;
};

/// Of the trace of P before an update, from where on a run ends, as not positive definite: the variance of
/// the squares of such errors is no number.
inline constexpr double kLargestTrace = 1e150;

/// LinearFilter for 32 runs of a monobot at a time, each with the measurements and so the P, K and S of its
/// own, one run a SIMD lane: what LinearFilter computes, to rounding.
///
/// Noise of run i: step 0, purpose initial, slots 0 … n − 1; step k, purpose process, slot 0; purposes
/// measurement and detection, slots 0 … m − 1. A lane's bits depend on its own run alone, and not on the
/// instruction set. Nothing is allocated after the construction.
class IntermittentLanes {
 public:
  static constexpr int kLanes = NoiseSource::kLanes;

  /// True for what the lanes can do: a monobot whose measurement and initial variances are positive, without
  /// inflation, or with a constant or pairwise one.
  static bool support(const IntermittentProblem& problem);

  /// Throws std::invalid_argument where support is false.
  IntermittentLanes(const IntermittentProblem& problem, const NoiseSource& source);
  IntermittentLanes(const IntermittentLanes&) = delete;
  IntermittentLanes& operator=(const IntermittentLanes&) = delete;

  /// The runs first_run … first_run + runs − 1 at their start, runs <= kLanes.
  void start(std::int64_t first_run, int runs);

  /// The steps that follow, at least one and at most `most`; returns how many. A run that fails ends there.
  Index advance(Index most);

  /// Adds the steps of the last `advance`; step k, from 1 on, is statistics.steps[k − 1].
  void add_to(StudyStatistics& statistics) const;

  /// Adds the averages over the runs since `start` that have not failed.
  void add_runs_to(StudyStatistics& statistics) const;

  Outcome outcome(int lane) const { return ended_[static_cast<std::size_t>(lane)].outcome; }

  /// Of one lane: e = x − x̂ and P after the last step, a number of that step, and whether it had measurement
  /// `row`.
  Vector error(int lane) const;
  Matrix covariance(int lane) const;
  double value(IntermittentValue value, int lane) const { return values(count_ - 1, value)[lane]; }
  bool seen(Index row, int lane) const { return seen_of(row, count_ - 1)[lane] != 0.0; }

 private:
  const double* values(Index step, int value) const;
  void draw();
  void find_failures();
  bool counts(int lane, Index step) const;
  void add_all(Index k, StepStatistics& s) const;
  void add_one(Index k, int lane, StepStatistics& s) const;
  const double* seen_of(Index row, Index k) const;
  /// Of an element of errors_ or covariance_, which have `rows` rows.
  std::size_t index(Index rows, Index row, int lane) const;

  double probability_, initial_std_;
  Matrix initial_;  ///< P0 as assumed
  Vector constant_;
  IntermittentPlan plan_;
  const IntermittentKernel* kernel_;
  NoiseSource source_;
  Index measurements_, block_;  ///< steps whose noise is drawn at once
  std::int64_t first_run_ = 0;
  int runs_ = 0;
  Index step_ = 0, count_ = 0;  ///< steps done, and those of the last call
  Index drawn_ = 0;             ///< steps whose noise has been drawn
  std::array<RunFailure, kLanes> ended_;
  std::array<double, kLanes> run_nees_{};  ///< summed over the steps since `start`
  bool failed_ = false;                    ///< any of them
  AlignedVector errors_, covariance_, process_, measurement_, seen_, work_, values_, mean_, m2_;
};

}  // namespace credence::internal
