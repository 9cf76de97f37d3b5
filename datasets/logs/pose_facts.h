#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/nan.h"

/// @file
/// What readers of poses find beside errors: numbers for the report, in which nothing is judged.

namespace credence::internal {

/// The NEES of a log of poses in one chart (pose_chart.h).
struct ChartNees {
  std::string chart;
  double as_written = kNaN;  ///< mean, if what is written were of this chart
  double p_value = kNaN;     ///< that errors and covariance, read so, belong together (ReadingFit)
  double carried = kNaN;     ///< mean, of the declared covariance carried over into this chart
};

/// The charts of one log.
struct ChartFindings {
  std::string declared;
  std::int64_t rows = 0;            ///< at most 4096, evenly spread
  std::vector<ChartNees> charts{};  ///< empty for a planar pose
};

/// The constant time between an estimate and its truth.
struct TimeOffset {
  double value_s = kNaN;  ///< what the times of the truth are ahead of those of the estimate
  double lower_s = kNaN, upper_s = kNaN;
  double confidence = 0.95;
  bool estimated = false;    ///< false: a number of the user, without an interval
  std::int64_t rows = 0;     ///< that it rests on
  std::int64_t files = 1;    ///< the same
  bool whole_files = false;  ///< the interval is by how the files differ; else by how each varies in time
  std::string reason{};      ///< why there is none, or no interval. Else empty
  double taken = kNaN;  ///< the largest share of Σ eᵀP⁻¹e that it took away, at the ends of the interval
  /// Of several files: how probable it is that they have one offset, and the best ones of each, where they
  /// would take more than a fiftieth of Σ eᵀP⁻¹e away. NaN where it cannot be told, or nothing is wrong.
  double p_agreement = kNaN, least_s = kNaN, most_s = kNaN;
};

/// What a reader of poses found in a file.
struct LogPoses {
  std::filesystem::path file;
  ChartFindings charts{};
  std::optional<TimeOffset> time_offset{};
};

}  // namespace credence::internal
