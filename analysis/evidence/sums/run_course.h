#pragma once

#include <cstdint>
#include <span>

namespace credence::internal {

/// How NEES of a run went over its rows.
struct RunCourse {
  double mean = 0.0;  ///< of NEES over its dof
  std::int64_t rows = 0;
  std::int64_t beyond = 0;  ///< rows with a NEES that no consistent filter has
  std::int64_t first = 0;   ///< of them the first, from 1; 0: there is none
};

/// That of one of the runs; of one that failed up to the step before.
struct CourseOfRun {
  std::int64_t run = 0;        ///< its number, from 0
  std::int64_t failed_at = 0;  ///< the step, from 1; 0: it did not fail
  RunCourse course{};
};

/// Of NEES over dof at every row, each of at least `least_dof`. Beyond is a row where a consistent filter is
/// once in 10^9: in a thousand studies of 10^6 rows one is, however the rows depend on each other.
RunCourse course_of(std::span<const double> nees, double least_dof);

}  // namespace credence::internal
