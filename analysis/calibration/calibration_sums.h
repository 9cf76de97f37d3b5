#pragma once

#include <array>
#include <boost/container/flat_map.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "analysis/calibration/distance_sums.h"
#include "core/linear_algebra/small_cholesky.h"
#include "core/nan.h"
#include "core/record/normalised_step.h"
#include "core/record/run_layout.h"
#include "core/record/step.h"

/// @file
/// Where and by how much a covariance is wrong, as sums over stretches of runs; calibration.h concludes.

namespace credence::internal {

inline constexpr double kCovered = 0.95;                ///< of the rows or runs, by a coverage factor
inline constexpr double kStanfordCellsOfADecade = 8.0;  ///< of position error and of its largest σ, m

/// Sums over some rows of one run; two of them add up to the sums over both.
struct CalibrationSum {
  /// A state at claimed standard deviations from 10^(bin/4) to 10^((bin+1)/4).
  struct Bin {
    std::int64_t rows = 0;
    double squared = 0.0, variance = 0.0;  ///< Σ e², Σ σ²
    double normalised = 0.0;               ///< Σ e²/σ²
  };

  std::int64_t rows = 0;
  double nees = 0.0;             ///< Σ eᵀ P⁻¹ e / n
  std::vector<double> marginal;  ///< of each part: Σ e_aᵀ (P_aa)⁻¹ e_a / n_a
  /// Of each pair a ≤ b of parts, by rows: Σ e_aᵀ (P⁻¹)_ab e_b, twice for a < b. With P scaled by f_a in part
  /// a, and √(f_a f_b) between two, NEES is the sum of these over √(f_a f_b).
  std::vector<double> pairs;
  boost::container::flat_map<std::pair<Index, int>, Bin> bins;  ///< by state and bin

  /// Of so many parts, without rows; keeps its memory.
  void clear(std::size_t parts);
  void merge(const CalibrationSum& later);
};

/// What a run leaves behind.
struct CalibrationRun {
  static constexpr std::size_t kTenths = 10;

  std::string name;  ///< of its file, with its number where the file holds several
  CalibrationSum whole;
  /// Its tenths, or the halves of these, the shorter ones, as far as each is longer than five correlation
  /// times of NEES, the least that may do (shortest_stretch); else none. Not of a run behind the first few,
  /// of which stretches are never looked at.
  std::vector<CalibrationSum> stretches{};
  double correlation_time = 1.0;  ///< of its NEES, in rows
  double effective_rows = 1.0;    ///< independent rows that its NEES is worth; at least 1
  /// The factor on P with which 95 % of the rows lie in their 95 % ellipsoid: the quantile of NEES /
  /// χ²₀.₉₅(n).
  double coverage_factor = 0.0;
  /// Rows whose position error is beyond the protection level of each of kRisks.
  std::array<std::int64_t, 3> beyond{};
  Index position_dim = 0;  ///< 0: there is no position
  /// Rows by position error and protection level over k, √λ_max(P): cell i holds 10^(i/8) to 10^((i+1)/8) m.
  std::map<std::pair<int, int>, std::int64_t> stanford{};
  DistanceSums distance{};  ///< empty where the way is not known
};

/// Of a step whose P = L Lᵀ was factored already; null where it was not.
struct FactoredState {
  const SmallCholesky* factor = nullptr;
  const NormalisedStep* normalised = nullptr;
};

/// Adds up the rows of runs that are complete, of up to twelve states with a joint covariance; where runs
/// differ in their states, those of the first run with most of them count. Rows with a P that is not positive
/// definite are left to EvidenceRecorder.
class CalibrationRecorder {
 public:
  static constexpr Index kLargest = 12;
  static constexpr std::size_t kMostRuns = 4096;
  static constexpr std::array<double, 3> kRisks = {1e-2, 1e-3, 1e-5};

  /// Whether rows of this layout can be used.
  static bool takes(const RunLayout& layout);

  void begin_run(const RunLayout& layout, std::string name);
  /// The run that is open has this name after all.
  void rename_run(std::string name) { run_.name = std::move(name); }
  /// The run that is open failed, and counts nothing.
  void drop_run() { open_ = false; }
  /// distance_m: that the truth has travelled in the run so far; NaN where it is not known. `factored`: of
  /// this step, by an EvidenceRecorder of the same layout, so that it is not done again.
  void add(const Step& step, double distance_m = kNaN, FactoredState factored = {});
  /// The same of what is known of the step alone, neither of which is null.
  void add(FactoredState factored, double distance_m);

  /// Of the runs so far, at most kMostRuns, in their order.
  std::vector<CalibrationRun> take();
  /// The parts of the state: its blocks that cut it; one, "state", where none do.
  const std::vector<Block>& parts() const { return parts_; }
  /// Their states and blocks.
  const RunLayout& layout() const { return layout_; }

 private:
  void close_run();
  /// Of the run at hand.
  void add_stretches();
  CalibrationSum& group_at_hand();
  /// An error of all states, its P = L Lᵀ, and eᵀ P⁻¹ e.
  struct Row {
    const Vector& error;
    const Matrix& P;
    double nees = 0.0;
    FactoredState factored{};
  };
  void add(const Row& row, double distance_m);
  void add_parts(const Row& row, CalibrationSum& sum);
  void add_position(const Row& row, DistanceSums::Bin& here);
  /// That of a state with this variance in `sum`, which is the group at hand.
  CalibrationSum::Bin& bin_of(Index state, double variance, CalibrationSum& sum);

  RunLayout layout_;
  std::vector<Block> parts_;
  std::vector<std::size_t> block_of_part_;  ///< of the layout
  std::vector<Index> position_;             ///< states of the position
  std::array<double, 3> limits_{};          ///< χ² of kRisks
  std::vector<CalibrationSum>
      groups_;  ///< the first open_groups_ are of the open run, of equal numbers of rows
  std::size_t open_groups_ = 0;
  std::int64_t rows_per_group_ = 1;
  std::vector<double> nees_;  ///< of the open run, of each row over n
  // Of the step at hand.
  SmallCholesky factor_, part_factor_;
  Vector whitened_, part_error_;
  Matrix parts_whitened_, part_P_;
  struct LastBin {
    double above = 0.0, below = 0.0;  ///< variances between them are of this bin
    int bin = 0;
    std::ptrdiff_t place = -1;  ///< of its sums among the bins of the group at hand; −1: to be looked for
  };
  std::vector<LastBin> last_bins_;  ///< of each state
  CalibrationRun run_;
  bool open_ = false;
  std::vector<CalibrationRun> runs_;
};

/// What is kept of several recorders, in the order of their runs.
struct CalibrationUnits {
  std::vector<CalibrationRun> runs{};  ///< the first CalibrationRecorder::kMostRuns
  std::vector<Block> parts{};
  RunLayout layout{};    ///< of all these runs
  double memory = kNaN;  ///< memory_in_rows of these runs

  /// Of runs with other states the first with most of them stay.
  void append(CalibrationRecorder& later);
  /// Their stretches are not independent.
  void keep_whole_runs();
};

/// A partition of the states by blocks, poses apart as position and heading, landmarks together; one part of
/// all where none is.
std::vector<Block> calibration_parts(const RunLayout& layout);

}  // namespace credence::internal
