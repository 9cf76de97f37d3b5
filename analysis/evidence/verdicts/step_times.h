#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/nan.h"

namespace credence::internal {

/// When the steps of runs were, in seconds, as far as all runs agree to half a step.
///
/// Runs that began at other times agree where the time since their first row does. Of long runs every s-th
/// step is kept, as of all sums by step (step_series.h).
class StepTimes {
 public:
  /// Of simulated runs, whose step k is at k step_s; null where that is not > 0, as of a world without times.
  static std::shared_ptr<const StepTimes> every(double step_s);

  /// The next steps are of another run.
  void begin_run() { run_begin_s_ = kNaN; }
  /// The step (from 1) of that run, later than those before it, was at this time; NaN: it has none.
  void add(std::int64_t step, double time_s);
  /// Adds runs that come after these.
  void merge(const StepTimes& later);

  bool known() const { return step_s_ > 0.0 || (agreed_ && last_step_ > first_step_); }
  /// Times are as the runs tell them; else, of clocks that differ or count from 1970, since the first row.
  bool as_told() const;
  /// Between two steps, on average; of times that are known.
  double interval_s() const;
  /// NaN where not known.
  double at(std::int64_t step) const;
  /// " (t = 18.8 s)", " (t = 18.8 to 20.1 s)" or " (18.8 s after the start)"; "" where not known.
  std::string text(std::int64_t first, std::int64_t last) const;

 private:
  /// As add, but for when the run began.
  void place(std::int64_t step, double time_s);

  double step_s_ = 0.0;            ///< of simulated runs, and then all that is known
  std::vector<double> elapsed_s_;  ///< at the steps 1, 1 + stride, …, since the first row; NaN: not known
  std::int64_t stride_ = 1;
  std::int64_t first_step_ = 0, last_step_ = 0;             ///< that are known; 0: none
  double last_elapsed_s_ = 0.0;                             ///< at last_step_
  double earliest_begin_s_ = kNaN, latest_begin_s_ = kNaN;  ///< of the runs
  double run_begin_s_ = kNaN;  ///< of the open run: its times less elapsed_s_; NaN: it has none yet
  bool agreed_ = true;
};

}  // namespace credence::internal
