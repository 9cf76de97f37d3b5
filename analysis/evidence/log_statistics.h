#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/laws/consistency_vector_moments.h"
#include "analysis/laws/goodness_of_fit_histogram.h"
#include "analysis/laws/whiteness.h"
#include "core/record/filter_row.h"
#include "montecarlo/engine/study_statistics.h"
#include "montecarlo/worlds/planar/state_error.h"

/// @file
/// What is accumulated over the logs of a filter: the sums of a study of our own (study_statistics.h), and
/// what else a log can tell.

namespace credence {

/// One number at one step over all runs, with the sum of its dof.
struct StepSums {
  Moments value;
  std::int64_t dof = 0;

  bool operator==(const StepSums&) const = default;
};

/// Step k is entry k − 1; series of different lengths add up to the longer one.
using SumsOverSteps = std::vector<StepSums>;
void merge_sums(SumsOverSteps& sums, const SumsOverSteps& later);

/// The innovations of one sensor.
struct SensorStatistics {
  SumsOverSteps nis;
  std::map<Index, StepSums> by_dimension;
  Index dim = 0;        ///< the largest of all logs
  bool varies = false;  ///< the dimension is not the same in all rows
  /// Of the normalised innovation u; empty once the dimension varies, or above kLargestWhitened.
  std::optional<LagProducts> lags;
  std::optional<VectorMoments> mean;
  /// Of Σ u_i/√m, which is N(0, 1) under consistency for any m.
  LagProducts scalar_lags;
  VectorMoments scalar_mean;

  static constexpr Index kLags = 10, kLargestWhitened = 12;
  SensorStatistics();
  void merge(const SensorStatistics& later);
};

/// Rows left out for one reason.
struct RejectedRows {
  std::int64_t count = 0;
  std::string first;  ///< "FILE:LINE"
};

/// All runs of some logs; additive in the order of the runs.
struct LogStatistics {
  StudyStatistics study;                        ///< its failures count the runs of these logs from 0
  std::map<std::string, SumsOverSteps> blocks;  ///< marginal NEES by the name of the block
  std::map<std::string, SensorStatistics> sensors;
  UniformHistogram nis_fit;             ///< F(NIS) over all rows and sensors
  SumsOverSteps clean_nees, clean_nis;  ///< without gross outliers
  std::int64_t nees_outliers = 0, nis_outliers = 0;
  std::int64_t rows = 0;                         ///< read, rejected ones included
  std::map<std::string, RejectedRows> rejected;  ///< by the reason
  std::vector<double> first_run;  ///< NEES / dof of a run alone at its rows; empty once there are more runs
  Index state_dim = 0;            ///< the largest of all logs
  bool joint_covariance = true, has_truth = false;

  void merge(LogStatistics later);
  std::int64_t rejected_rows() const;
};

/// Adds rows to the sums: NEES over the range of P with angles wrapped, NIS, and their relatives.
///
/// A row whose P or S is not positive semidefinite, not symmetric, or whose error lies where P claims
/// certainty, is counted as rejected with its reason and never repaired: neither its NEES nor its NIS counts.
class LogAccumulator {
 public:
  /// The next rows come from this file.
  void begin_file(const std::filesystem::path& file, const FilterLogLayout& layout);
  /// The next rows belong to another run.
  void begin_run();
  /// The run that is open ended badly.
  void end_run(Outcome outcome, std::int64_t step);
  void add(const FilterRow& row);

  /// The chunks of kChunkRuns runs that are full; the caller merges them in their order.
  std::vector<LogStatistics> take_chunks() { return std::exchange(full_, {}); }
  /// The sums of the last chunk; the next ones begin at nothing.
  LogStatistics take();

 private:
  struct Block {
    std::string name;
    std::vector<Index> states;  // of the layout
    bool pose = false;          // x, y and an angle
  };
  struct Normalised {
    double value = 0.0;
    Vector whitened{};
    Index dof = 0;
    std::string_view problem = {};
  };

  Normalised normalise(const Vector& error, const Matrix& P);
  std::string_view judge_state(const FilterRow& row);
  std::string_view judge_innovations(const FilterRow& row);
  void add_state(const FilterRow& row, StepStatistics& step);
  void add_innovations(StepStatistics& step, std::size_t k);
  void add_planar_slam(const FilterRow& row, StepStatistics& step) const;
  StepSums& at(SumsOverSteps& sums, std::size_t k) const;

  std::string file_;
  FilterLogLayout layout_;
  std::vector<Block> blocks_;
  bool planar_slam_ = false, line_world_ = false;
  LogStatistics sums_;
  std::vector<LogStatistics> full_;
  NeesSolver solver_;
  Normalised state_;                     // of the row at hand
  std::vector<NeesValue> block_values_;  // of the row at hand
  std::vector<Normalised> innovations_;  // of the row at hand
};

/// Beyond this upper quantile of its χ² law a value is a gross outlier: once in a million for a consistent
/// filter.
inline constexpr double kGrossOutlier = 1e-6;

}  // namespace credence
