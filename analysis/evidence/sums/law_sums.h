#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "analysis/evidence/sums/run_samples.h"
#include "analysis/laws/correlation/group_sums.h"
#include "analysis/laws/shape/second_moments.h"
#include "analysis/laws/shape/tail_weight.h"
#include "analysis/laws/shape/vector_moments.h"
#include "core/record/run_layout.h"
#include "montecarlo/engine/skewed_moments.h"

/// @file
/// Sums that tell a covariance that is wrong from errors that are not Gaussian, and a direction of P that is
/// wrong from a common factor. Units are whole runs, or the runs at one step.

namespace credence::internal {

/// The normalised errors u of an open run, of whose rows some, evenly over it, stand for those about them.
struct RunWhitened {
  Matrix outer{};                 ///< Σ u uᵀ of rows that are taken, its lower triangle
  GroupSums sums{};               ///< Σ u of successive groups of all rows
  Index squared = 0;              ///< rows that `outer` stands for
  bool by_group = false;          ///< whether these are summed for each group as well:
  std::vector<Matrix> squares{};  ///< Σ u uᵀ of rows that are taken, their lower triangles
  std::vector<Index> squared_of_group{};

  /// Whether the next row is taken where so many of every group are, a power of two.
  bool takes(Index of_group) const;
  /// A row that is taken.
  void add(const Vector& whitened, Index of_group);
  /// One that is not.
  void skip();
  /// Any row: `sums` are of all, `outer` of those that are taken.
  void add_each(const Vector& normalised, Index of_group);
  /// Of rows that were all taken or skipped.
  Vector mean() const;

 private:
  /// Of how many rows one is taken.
  Index every(Index of_group) const;
  void add_square(const Vector& of, Index times);
  /// The next row: the sum of its group.
  Eigen::Map<Vector> next(Index dim);
  void begin_squares(Index dim);
};

/// Averages over tenths of runs, of the errors of the whole state, whitened or, of a large one, over their σ:
/// whether one lasts for a tenth, as it is or as an oscillation.
struct StretchSums {
  static constexpr Index kLargest = 200;         ///< a larger state is looked at by its first ones
  static constexpr std::int64_t kMostRuns = 19;  ///< of more no stretches are compared (stretch_averages)

  std::int64_t runs = 0;
  Matrix square{};           ///< Σ over the runs of the average of u uᵀ, its lower triangle
  VectorMoments means{};     ///< of the averages
  double oscillating = 0.0;  ///< Σ over the runs of oscillating_share
  Index samples = 0;         ///< that it is of
  Matrix across{};  ///< Σ over the runs of (a bᵀ + b aᵀ)/2, averages of their first and last three tenths
  Matrix between{};  ///< Σ over the runs of half the mean square of what neighbouring tenths differ by

  /// Of a run of fewer than ten rows nothing; of files with other states those with most count.
  void add(const RunWhitened& run, const RunSamples& samples);
  void merge(const StretchSums& later);
  /// Whether an error lasts for tenths of the runs, or nearly so: these are then not independent, however
  /// short the correlation time of NEES is, which an error that lasts hardly shows among many that do not.
  /// effective_rows: that the NEES of the runs is worth.
  bool stand(double effective_rows) const;
  /// Whether one stays as it is over all of one run.
  bool stay() const;
  /// Whether one lasts for tenths as it is.
  bool last(double effective_rows) const;
  /// Whether one oscillates over the runs (oscillating_share).
  bool oscillate(double effective_rows) const;
  /// Whether a part of the errors stays over the runs that moves their mean NEES by as much as chance does,
  /// or may: a and b of `across` are alike then, by 2½ standard errors of what is forgotten between them,
  /// which `between` tells. Of that part the runs show R d values, d the number of its directions, so that it
  /// may be larger than it is seen by R d over the quantile of χ²(R d) at 5 %.
  bool persist(double effective_rows) const;

 private:
  bool takes(Index dim);
};

/// The average of u uᵀ over equal stretches of few runs, which are the units where the runs alone are too
/// few.
struct StretchMoments {
  /// Of each run: as many as make twenty of all, from 19 runs to one.
  static constexpr std::array<Index, 7> kStretches = {2, 3, 4, 5, 7, 10, 20};

  std::array<SecondMoments, kStretches.size()> of{};

  void add(const RunWhitened& run);
  void merge(const StretchMoments& later);
  /// Those of so many runs; of none where a run has no such stretches.
  SecondMoments of_runs(std::int64_t runs) const;
};

/// The largest map whose errors are averaged whole: of a larger one not every step is whitened, and a study
/// has the landmarks that nothing has seen, its logs not.
inline constexpr Index kLargestAveragedMap = 12;
/// The largest state whose errors are averaged over each run; of a larger one those of the block that leads
/// are (lead_block).
Index largest_averaged(const RunLayout& layout);

/// Of all runs.
struct LawSums {
  static constexpr Index kLargestShape = 24;

  std::string averaged{};                            ///< the block that second_moments is of; "": the state
  SecondMoments second_moments{};                    ///< of the whitened errors, averaged over each run
  VectorMoments error_means{};                       ///< of the errors over their σ, averaged over each run
  std::vector<bool> correlated{};                    ///< of each pair of such states (pair_of): P claims that
                                                     ///< they are, at some step; empty for a block
  VectorMoments whitened_means{};                    ///< of the whitened errors, averaged over each run
  StretchSums stretches{};                           ///< of the whole state
  StretchMoments stretch_moments{};                  ///< of what second_moments is of; of few runs
  std::map<std::int64_t, VectorMoments> whitened{};  ///< of the whole state at steps 1, 2, 4, 8, …
  TailSums nees_tails{}, nis_tails{};
  SkewedMoments nis_of_runs{};          ///< NIS / dof, averaged over each run
  std::vector<SkewedMoments> nis_at{};  ///< NIS / dof at each step over the runs

  void merge(const LawSums& later);
  /// Whether the averages over a run of `dim` states of the block `of` ("": the state) are added up here.
  /// Files may have other states: what has most of them counts, and what was there of fewer is dropped.
  bool takes(const std::string& of, Index dim);
  /// Adds the whitened error of the whole state at a step; of files with other states those with most count.
  void add_whitened(std::int64_t step, const Vector& error);
  /// Whether an error stays as it is over the runs (standing_share), so that their stretches tell no more
  /// than they do: of what is averaged.
  bool errors_stand() const;
};

/// Where states q < p are among the pairs of states.
constexpr std::size_t pair_of(Index p, Index q) { return static_cast<std::size_t>(p * (p - 1) / 2 + q); }

/// Of the run at hand.
struct RunLaw {
  bool few = false;                      ///< it is one of few runs, whose stretches may be compared
  RunWhitened averaged{};                ///< u = R^{-1/2} D⁻¹ e of the state, or of a block of a large one
  RunSamples samples{}, lead_samples{};  ///< of few runs: of the state, and of the block that leads
  RunWhitened large{};  ///< D⁻¹ e of a state that is not averaged, or of rows that lack states, of few runs
  Vector normalised{};             ///< Σ D⁻¹ e of what is averaged, of all rows
  Index errors = 0;                ///< those rows
  std::vector<bool> correlated{};  ///< as LawSums::correlated
  RunTails nees_tails{}, nis_tails{};
  double nis = 0.0, nis_dof = 0.0;

  /// An error whose covariance is of full rank; whether it is to be whitened, too. Of few runs, and up to six
  /// states, all of 512 rows are and 256 of every doubling of the run; of more states all of 64 and 32:
  /// errors are correlated in time, and a root of P is dear.
  bool add_error(const Vector& error, const Vector& variance);
  /// It whitened by P, which tells the states that are claimed to be correlated.
  void add_whitened(const Vector& whitened, const Matrix& P);
  /// Of a run of so many rows those of the state, or else of the block that leads, which all rows have; none
  /// where neither is in all.
  const RunSamples& samples_of_all(Index rows) const;
  /// The run ended well; `of` is the block of the errors, "" for the state.
  void add_to(LawSums& sums, const std::string& of) const;
};

/// Whether the shape of P is looked at: at few steps, so that each is tested at nearly the full level, and
/// densely at the start, where P changes.
bool is_shape_step(std::int64_t step);

}  // namespace credence::internal
