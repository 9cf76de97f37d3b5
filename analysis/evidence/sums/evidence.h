#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "analysis/evidence/sums/law_sums.h"
#include "analysis/evidence/sums/run_course.h"
#include "analysis/evidence/sums/score_sums.h"
#include "analysis/evidence/sums/whole_turns.h"
#include "analysis/laws/correlation/coarse_series.h"
#include "analysis/laws/correlation/lateness.h"
#include "analysis/laws/correlation/long_lags.h"
#include "analysis/laws/correlation/whiteness.h"
#include "analysis/laws/gate_rejection.h"
#include "analysis/laws/shape/coverage.h"
#include "analysis/laws/shape/uniform_histogram.h"
#include "analysis/laws/shape/vector_moments.h"
#include "core/record/run_layout.h"
#include "montecarlo/engine/study_statistics.h"

/// @file
/// What the steps of a filter add up to, whoever produced them: the engine, a log, a replay or the selftest.
/// Sums only; judgement.h concludes. Everything merges, in the order of the runs for the same bits.

namespace credence::internal {

/// One number at one step over all runs, with the sum of its dof.
struct StepSums {
  Moments value;
  std::int64_t dof = 0;

  void add(double x, Index x_dof) {
    value.add(x);
    dof += x_dof;
  }
  void merge(const StepSums& later) {
    value.merge(later.value);
    dof += later.dof;
  }
  bool operator==(const StepSums&) const = default;
};

/// Of every step (step_series.h).
using SumsOverSteps = std::vector<StepSums>;

/// One block of the state.
struct BlockSums {
  std::string name;
  Part part = Part::other;
  SumsOverSteps nees;
  RunAverages runs;               ///< of NEES
  std::vector<CoarseSeries> few;  ///< NEES / dof over the steps of each run, of few (StretchSums::kMostRuns)
  SkewedMoments squared_error;    ///< of ‖e‖² averaged over each whole run, of a map for each landmark
  Moments claimed;                ///< the same of tr P

  void merge(const BlockSums& later);
};

/// How often the truth lies within kσ of the whole state.
struct CoverageSums {
  static constexpr std::array<double, 3> kSigmas = {1.0, 2.0, 3.0};

  struct Region {
    std::vector<CoverageCount> count;  ///< at each step
    std::vector<double> expected;      ///< sum over runs of P(χ²(dof) ≤ k²)
  };
  std::array<Region, kSigmas.size()> regions;

  void add(std::int64_t step, double nees, Index dof);
  void merge(const CoverageSums& later);
  void drop_every_second_step();

 private:
  std::map<Index, std::array<double, kSigmas.size()>> expected_of_dof_;  ///< computed once for each dof
};

/// The innovations of one sensor, normalised as u = L⁻¹ν, S = L Lᵀ: independent N(0, I) for a consistent
/// filter. A u is taken apart into pieces (Sensor::piece), the j-th being followed through time. Correlation
/// and mean leave out the first fifth of each run, where a wrong start would show in everything.
///
/// Of a sensor with NIS alone u is the one number Φ⁻¹(F(NIS)) less its mean over the run: white as long as
/// the NIS are independent and of one law, be the scale of S right or wrong; nothing is known of the mean.
/// What that takes off every product, the variance over the number of values, is added again, as over many
/// runs it would add up.
struct SensorSums {
  static constexpr Index kLargestWhitened = 12;  ///< a larger piece is looked at by one number, Σ u_i/√m
  static constexpr double kFarTail = 0.9999;     ///< NIS beyond this quantile of its law counts as an outlier

  explicit SensorSums(Sensor of);  ///< with a piece of at least 1
  void merge(const SensorSums& later);

  Sensor sensor;  ///< dim: the largest of all logs
  bool varies;    ///< the dimension is no multiple of the piece, or not the same in all logs
  SumsOverSteps nis;
  std::map<Index, StepSums> by_dimension;
  UniformHistogram fit;    ///< F(NIS)
  CoverageCount far_tail;  ///< NIS values within the quantile kFarTail
  double largest_nis = 0.0;
  CoverageCount ties;       ///< NIS that are equal to another of their run: never of a continuous law
  LongLags lags;            ///< of the pieces; means nothing once the dimension varies
  VectorMoments run_means;  ///< over runs: the mean piece of each, so that it holds for coloured ones too
  VectorMoments first;      ///< over runs: the first u of each, where it is one piece
  /// Of Σ u_i/√m, which is N(0, 1) under consistency for any m.
  LongLags scalar_lags;
  VectorMoments scalar_run_means;
  VectorMoments values, scalar_values;  ///< of all pieces: for too few runs to compare their means
  /// ν_j²/S_jj of each component of a piece of several, after the first fifth of each run.
  std::vector<Moments> components;
  /// The same of (ν_p/σ_p ± ν_q/σ_q)²/(2 (1 ± r_pq)) of every two of them, r the correlation that S has, q <
  /// p: of 1 and 0 the sum and the difference, of 2 and 0, of 2 and 1, and so on.
  std::vector<Moments> pairs;
  Moments measurement_share;      ///< tr(S⁻¹ R)/m: the part of S that is R
  ChangesByNis changes;           ///< of log det P, after the first fifth of each run
  std::int64_t unwrapped = 0;     ///< components that are angles, beyond half a turn
  std::vector<WholeTurns> turns;  ///< of the components of a piece that are not marked as angles
};

/// The normalised innovations of two sensors at the same steps, one under the other: uncorrelated where the
/// second sensor was taken after the update by the first, or S holds their covariance.
struct SensorPairSums {
  static constexpr Index kLargest = 24;  ///< components of both together

  std::string first, second;
  Index first_dim = 0;
  VectorMoments both{};

  /// Whether the values of sensors of these dimensions are of the same kind as those that are here.
  bool fits(Index of_first, Index of_both) const {
    return both.count == 0 || (first_dim == of_first && both.mean.size() == of_both);
  }
};

/// What whole runs say. Only runs that ended well count.
struct RunSums {
  static constexpr std::size_t kKept = 1024;  ///< runs of which the course in time is kept

  Moments nees_values;                    ///< of all steps
  std::vector<std::vector<double>> nees;  ///< of each of the first kKept runs, NEES / dof over its steps
  std::vector<Vector> last_error;         ///< of the block that leads (lead_block), at the end of each
  std::vector<Matrix> last_covariance;
  std::vector<RunCourse> further;     ///< how NEES went in the runs behind the first kKept
  std::vector<Matrix> samples;        ///< of few runs (RunLaw::samples_of_all)
  std::vector<Vector> log_variances;  ///< of these samples
  VectorMoments last_whitened;      ///< of the whole state at the end (correlation_whitening.h); only of runs
                                    ///< with as many states, of which P is of full rank
  std::vector<CourseOfRun> failed;  ///< of the runs that failed, of which nothing else here is

  /// least_dof: of the NEES of `later`.
  void merge(const RunSums& later, double least_dof);
  /// NEES / dof of a run over its steps; samples: of one of few.
  void add(std::vector<double> nees_of_run, const RunSamples* samples_of_run);
  /// How NEES went in every run; least_dof: of the first kKept.
  std::vector<RunCourse> courses(double least_dof) const;

 private:
  void drop_samples_of_many();  ///< of more than few runs none are kept
};

/// Rows of which one thing is said.
struct CountedRows {
  std::int64_t count = 0;
  std::string first;  ///< "FILE:LINE"; empty: of no file
};

/// All runs of a filter.
struct Evidence {
  RunLayout layout;       ///< of the first log, or of the world
  StudyStatistics study;  ///< its failures count the runs from 0
  std::vector<BlockSums> blocks;
  std::vector<SensorSums> sensors;
  CoverageSums coverage;
  RunSums whole_runs;
  LawSums law;
  LatenessSums lateness{};  ///< where estimates are known
  ScoreSums scores;
  std::vector<SensorPairSums> sensor_pairs;  ///< of the order of the layout
  SumsOverSteps clean_nees, clean_nis;       ///< without gross outliers
  std::int64_t nees_outliers = 0, nis_outliers = 0;
  std::map<std::string, WholeTurns> turns;  ///< of the errors of states that are not marked as angles
  CoverageCount narrow_angles{};            ///< angles of the state at a step whose σ is within kWideAngle
  std::int64_t rows = 0;                    ///< steps seen, rejected ones included
  std::int64_t step_stride = 1;             ///< of the steps that have sums of their own (step_series.h)
  std::map<std::string, CountedRows> rejected;         ///< rows left out, by the reason
  std::map<std::string, CountedRows> wrongly_certain;  ///< by the state that errs where its variance is 0
  std::vector<double> first_run;  ///< NEES / dof of a run alone at its rows; empty once there are more runs
  Index state_dim = 0;            ///< the largest of all logs
  bool joint_covariance = true, has_truth = false;

  void merge(Evidence later);
  /// Doubles step_stride until this step, and this stride, is provided for.
  void thin_steps(std::int64_t step, std::int64_t stride = 1);
  std::int64_t rejected_rows() const;
  std::int64_t wrongly_certain_rows() const;  ///< of the state with most of them
  BlockSums& block(const Block& of);          ///< made if it is not there
  SensorSums& sensor(const Sensor& of);       ///< made if it is not there
  /// Made if it is not there.
  SensorPairSums& sensor_pair(const std::string& first, const std::string& second, Index first_dim);
};

/// The σ of an angle beyond which its wrapped error is no longer Gaussian to the eye of NEES [rad].
inline constexpr double kWideAngle = std::numbers::pi / 3.0;

/// Beyond this upper quantile of its χ² law a value is a gross outlier: once in a million for a consistent
/// filter.
inline constexpr double kGrossOutlier = 1e-6;

/// The value beyond which a χ²(dof) is one; dof ≥ 1.
double outlier_limit(Index dof);

}  // namespace credence::internal
