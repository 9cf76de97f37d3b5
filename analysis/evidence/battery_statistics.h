#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "analysis/laws/consistency_vector_moments.h"
#include "analysis/laws/coverage.h"
#include "analysis/laws/goodness_of_fit_histogram.h"
#include "analysis/laws/whiteness.h"
#include "core/types.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/engine/moments.h"

/// @file
/// What the battery of tests accumulates over whole runs, beyond the NEES and NIS of every study. All of it
/// adds up: merge() takes the sums of later runs, in the order of the runs for the same bits.

namespace credence {

/// The size of what is to come.
struct BatteryShape {
  std::size_t steps = 0;
  Index vehicle_dim = 1;           ///< 1, or 3 for a planar pose whose last component is an angle
  Index landmark_dim = 1;          ///< of a landmark and of its measurement
  Index landmarks = 0;             ///< those that can become states
  Index innovation_dim = 0;        ///< where it is the same at every step, else 0
  Vector measurement_variances{};  ///< that the filter assumes for one landmark; empty: not known
};

/// NEES of one block of the state, at every step over the runs that have it in their state.
struct BlockSeries {
  std::string name;
  std::vector<Moments> nees;
  std::vector<double> dof;  ///< sum over runs

  void merge(const BlockSeries& other);
};

/// NEES of the blocks: the vehicle, in the plane its position and heading, each landmark, and all together.
class BlockStatistics {
 public:
  /// Landmarks with a block of their own; beyond that number only all together.
  static constexpr Index kSingleLandmarks = 50;

  explicit BlockStatistics(const BatteryShape& shape);
  /// error: x̂ − x of the state at step k = 0 …
  void add(std::size_t k, const Vector& error, const TraceStep& step);
  void merge(const BlockStatistics& other);
  const std::vector<BlockSeries>& series() const { return series_; }
  /// Of the whole state, over the same runs.
  const BlockSeries& whole() const { return whole_; }

 private:
  void add_block(std::size_t block, std::size_t k, VectorRef error, MatrixRef P);

  Index vehicle_dim_, landmark_dim_, single_landmarks_;
  bool all_landmarks_;
  std::vector<BlockSeries> series_;
  BlockSeries whole_;
};

/// How often the truth lies within kσ of the whole state, at every step.
struct CoverageStatistics {
  static constexpr std::array<double, 3> kSigmas = {1.0, 2.0, 3.0};

  explicit CoverageStatistics(std::size_t steps);
  void add(std::size_t k, double nees, Index dof);
  void merge(const CoverageStatistics& other);

  struct Region {
    std::vector<CoverageCount> count;  ///< at each step
    std::vector<double> expected;      ///< sum over runs of P(χ²(dof) ≤ k²)
  };
  std::array<Region, kSigmas.size()> regions;

 private:
  using Expected = std::array<double, kSigmas.size()>;
  std::map<Index, Expected> expected_of_dof_;  ///< computed once for each dof
};

/// The innovations, normalised as L⁻¹ν with S = L Lᵀ: independent N(0, I) for a consistent filter. Where
/// their dimension varies they are taken apart into pieces of the size of one landmark's measurement, the
/// j-th piece being followed through time. Correlation and mean leave out the first fifth of the steps, where
/// a wrong start would show in everything.
class InnovationStatistics {
 public:
  static constexpr Index kLags = 20;
  static constexpr Index kLargestDim = 4;     ///< larger innovations are taken apart too
  static constexpr double kFarTail = 0.9999;  ///< NIS beyond this quantile of its law counts as an outlier

  explicit InnovationStatistics(const BatteryShape& shape);
  void begin_run();
  void add(std::size_t k, const TraceStep& step);
  void end_run();
  void merge(const InnovationStatistics& other);

  UniformHistogram nis;       ///< F(nis; dof)
  LagProducts products;       ///< of the pieces
  VectorMoments run_mean;     ///< over runs: the mean piece of each, so that it holds for coloured ones too
  Moments measurement_share;  ///< tr(S⁻¹ R)/m: the part of S that is R
  CoverageCount far_tail;     ///< NIS values within the quantile kFarTail

 private:
  Vector variances_;
  std::size_t first_step_;
  std::vector<LagProducts> pieces_;  ///< of the current run
  Vector piece_sum_;
  std::int64_t piece_count_ = 0;
};

/// What whole runs say: averages over time, and the errors at the end.
struct RunStatistics {
  enum Part : std::size_t { position, heading, landmarks, parts };

  void begin_run();
  void add(const Vector& error, const TraceStep& step, const BatteryShape& shape);
  void end_run();
  void merge(const RunStatistics& other);

  Moments nees_values;                       ///< of all steps of all runs
  Moments nees_sum;                          ///< over runs: Σ_k NEES
  double expected_nees_sum = 0.0;            ///< the sum over runs of Σ_k dof
  std::vector<std::vector<double>> nees;     ///< of each run, over its steps
  std::array<Moments, parts> squared_error;  ///< over runs, mean over steps: m², rad², m²
  std::vector<Vector> last_vehicle_error;    ///< one for each run
  std::vector<Matrix> last_vehicle_covariance;

 private:
  std::vector<double> run_nees_;
  double run_dof_ = 0.0;
  std::array<Moments, parts> run_squared_error_;
  Vector vehicle_error_;
  Matrix vehicle_covariance_;
};

/// All of them.
class BatteryStatistics {
 public:
  explicit BatteryStatistics(const BatteryShape& shape);

  void begin_run();
  /// The steps of a run in order, from the start on, which counts for nothing. A step without NEES (dof 0:
  /// not computed, as in a step that failed) counts for nothing but its time.
  void add(const TraceStep& step);
  /// Only runs that ended `ok` count in what whole runs say.
  void end_run(Outcome outcome);
  void merge(const BatteryStatistics& other);

  BatteryShape shape;
  std::int64_t runs = 0;
  BlockStatistics blocks;
  CoverageStatistics coverage;
  InnovationStatistics innovations;
  RunStatistics whole_runs;

 private:
  std::size_t step_ = 0;  ///< of the current run
};

}  // namespace credence
