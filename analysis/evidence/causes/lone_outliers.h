#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// @file
/// Rows whose error is beyond any that P leaves room for, one at a time: a glitch of the truth, or of what
/// was logged, as errors of a filter fade and do not end from one row to the next.

namespace credence::internal {

struct LoneOutliers {
  std::int64_t count = 0;         ///< rows beyond kGrossOutlier
  std::int64_t rows = 0;          ///< of all runs
  std::int64_t run = 0, row = 0;  ///< of the first, from 0
  bool at_one_step = true;        ///< all are that row of their runs
};

/// Of NEES / dof of the rows of each run, dof the same in all. Nothing where they are more than one in
/// twenty, where one in five has a neighbour beyond as well, or where most are in the first tenth of their
/// run, at its first row or beside another that is larger than 99 in 100, as those of a P0 that is too small.
std::optional<LoneOutliers> find_lone_outliers(std::span<const std::vector<double>> runs, double dof);

}  // namespace credence::internal
