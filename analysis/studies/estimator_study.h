#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/mean/student.h"
#include "core/nan.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/engine/study_statistics.h"
#include "montecarlo/scenario/scenario.h"
#include "montecarlo/worlds/estimator_contest.h"

/// @file
/// Several estimators in one world, run by run with the same noise: who is consistent, who is accurate, at
/// what cost.
///
/// NEES of a run is Σ_k eᵀP⁻¹e / Σ_k dof over its steps; runs are independent, so intervals are over runs
/// (run_mean.h). Pose and map are judged in the chart of the estimator's own P, where the filter claims them
/// Gaussian; of the pose also what comes of P when it is transported to x̂ − x to first order at the estimate,
/// as published tables do for invariant filters. A run that fails is counted, named, and in no average.

namespace credence::internal {

class Ranks;

/// One estimator in one run that ended well.
struct EstimatorRunValues {
  std::array<double, kEstimatorBlocks> nees{};  ///< over dof; NaN where nothing was judged
  double heading_squared = 0.0;                 ///< rad², mean over the steps
  double position_squared = 0.0;                ///< m², mean over the steps
  double heading_variance = 0.0;                ///< rad², what P says of the former
  double position_variance = 0.0;               ///< m²
};

/// Levels of the bands over the runs.
inline constexpr std::array kBandLevels = {0.05, 0.25, 0.5, 0.75, 0.95};
using Band = std::array<double, kBandLevels.size()>;

/// So much more or less squared error than P claims is not held against an estimator of a sweep.
inline constexpr double kToleratedFactor = 1.1;

/// Whether the squared error may be twice what P claims, or half of it, for all that these runs tell.
inline bool may_be_twice(const MeanInterval& nees) { return nees.upper > 2.0; }
inline bool may_be_half(const MeanInterval& nees) { return nees.lower < 0.5; }
inline bool is_undecided(const MeanInterval& nees) { return may_be_twice(nees) || may_be_half(nees); }

/// One estimator over all runs.
struct EstimatorRow {
  std::string name;
  EstimatorProfile profile;
  std::int64_t runs = 0;                         ///< that ended well
  std::vector<RunFailure> failures;              ///< of the others
  std::vector<RunNotConverged> not_converged{};  ///< of all runs
  std::array<MeanInterval, kEstimatorBlocks> nees{};
  /// That the mean NEES is 1; of pose and map by Holm over both directions of all estimators.
  std::array<DirectedPValues, kEstimatorBlocks> p_values{};
  /// That the mean NEES of the pose is at most kToleratedFactor, at least its inverse; not adjusted, as what
  /// is not rejected is what is recommended.
  DirectedPValues beyond_tolerance;
  std::array<Band, kEstimatorBlocks> bands{};  ///< quantiles over the runs
  MeanInterval heading_rmse_rad, position_rmse_m;
  /// The bound's mean squared error over that of the estimator; 0 where the bound is, of count 0 without one.
  MeanInterval heading_efficiency, position_efficiency;
  double claimed_heading_rad = 0.0, claimed_position_m = 0.0;  ///< the RMSE that P claims
  std::vector<double> pose_nees;  ///< mean over the runs, of each window of steps
  std::vector<Band> pose_bands;   ///< the same as quantiles over the runs
  Index unobservable = 0;         ///< n − rank of the observability matrix at its own Jacobians, in run 0
  double rank_gap = 0.0;          ///< of that decision
};

/// E[first − second] over the runs that both ended well.
struct PairedDifference {
  std::string first, second;
  bool of_position = false;  ///< of the squared position error, m²; else of the pose NEES over dof
  MeanInterval difference;
  double p_value = 1.0;
  /// Variance that the difference would have with noise of its own for each, over that with common noise; NaN
  /// where there is no difference.
  double gain = kNaN;
};

/// An estimator that was not asked for by its name and refuses the scenario.
struct LeftOutEstimator {
  std::string name, reason;
};

/// Consistent, optimistic or pessimistic: a mean NEES whose adjusted p-value is at most 1 − confidence.
Verdict verdict_of(const EstimatorRow& row, EstimatorBlock block, double confidence);

/// Those that a comparison has, each by its name.
struct ChosenEstimators {
  std::vector<std::string> names;
  std::vector<LeftOutEstimator> left_out;
};

struct EstimatorStudy {
  Scenario scenario;
  std::vector<EstimatorRow> rows;
  std::vector<LeftOutEstimator> left_out{};
  std::vector<PairedDifference> paired;
  std::vector<double> window_ends;  ///< last step of each window of pose_nees
  VehicleBound bound;               ///< NaN: not known
  bool has_vehicle = true;          ///< false: heading is nothing, position all states, each in its unit
  Index map_stride = 1;             ///< the map is judged at every so many steps
  std::string note;                 ///< of the world
  std::string run_command;          ///< "credence run …" of the same scenario; empty: not known
  std::int64_t runs = 0;            ///< asked for
  bool complete = true;             ///< false: interrupted; the rows mean nothing
};

struct EstimatorStudyOptions {
  std::vector<std::string> estimators{};  ///< empty: all that take the scenario
  std::string run_command{};              ///< of EstimatorStudy
  int threads = 0;
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const StudyProgress&)> progress{};  ///< called under a lock
  Ranks* ranks = nullptr;  ///< share the runs among these; on others than rank 0 the study is not complete
};

/// The estimators that are asked for, or all of the world that take the scenario. Throws
/// std::invalid_argument for a world that offers none (World::estimators), for an estimator that it does not
/// have, and for a scenario that none of them takes.
ChosenEstimators choose_estimators(const Scenario& scenario, const std::vector<std::string>& asked);

/// Whether pose or map of an estimator is optimistic or pessimistic.
bool any_inconsistent(const EstimatorStudy& study);

/// Runs study.runs runs of the scenario with every estimator. Throws as choose_estimators, and what an
/// estimator that is asked for throws of the scenario.
EstimatorStudy study_estimators(const Scenario& scenario, const EstimatorStudyOptions& options);

}  // namespace credence::internal
