#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/sums/run_course.h"
#include "analysis/evidence/verdicts/consistency.h"

/// @file
/// Runs in which a filter lost its way while it held it in the others: whoever finds one run of twenty
/// diverged wants to look at that run, and not to scale P.

namespace credence::internal {

struct RunSums;

/// A run whose errors left P behind.
struct LostRun {
  std::int64_t run = 0;        ///< its number, from 0
  std::int64_t row = 0;        ///< the first with a NEES that no consistent filter has, from 1
  double factor = 0.0;         ///< its mean NEES over the expected one
  std::string name{};          ///< where it can be found, "run 13 of dv"; empty: it has its number alone
  std::int64_t failed_at = 0;  ///< step; 0: it did not fail
};

/// All of them, and the rest.
struct LostRuns {
  std::vector<LostRun> runs;  ///< in their order; empty: none
  std::int64_t others = 0;
  std::int64_t last = 0;           ///< the largest number of a run
  double factor_of_others = 1.0;   ///< the mean of their NEES over the expected one
  double p_value_of_others = 1.0;  ///< that it is 1, by Student's t of the means of these runs
  bool by_step = false;            ///< their rows are steps (rows_are_steps)

  /// Whether nothing is to be mended in these: the factor is within a quarter of 1, and nothing but chance.
  bool others_are_right() const {
    constexpr double kLevel = 0.05;
    return factor_of_others < 1.25 && factor_of_others > 0.8 && p_value_of_others > kLevel;
  }
};

/// The runs that are lost, of at least five of which no more than a quarter are.
///
/// Lost is a run with ten rows or more beyond (course_of), three of one that failed, and a mean NEES more
/// than ten times the median one. None are named where the mean NEES of the others is wrong by a factor of
/// two or more: then something is wrong with the filter in every run.
LostRuns find_lost_runs(std::span<const CourseOfRun> runs);

/// "run 7": its name, or its number.
std::string name_of(const LostRun& run);

/// "run 7 (of 0 to 19)", "runs 3, 7 (of 0 to 19)": by their numbers, or "run 13 of dv, run 2 of dw": by their
/// names.
std::string names_of(const LostRuns& lost);

/// Whether the rows of these runs are the steps of `nees`: each has a NEES at all of them, or up to the one
/// at which it failed.
bool rows_are_steps(const RunSums& runs, const ConsistencyVerdict& nees);

/// From when on a run is lost: "step 51 (t = 5.1 s)" where its rows are the steps of `nees` (by_step), else
/// "its row 51".
std::string place_of(const LostRun& run, bool by_step, const ConsistencyVerdict& nees);

}  // namespace credence::internal
