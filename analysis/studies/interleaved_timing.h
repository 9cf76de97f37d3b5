#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

/// @file
/// Times that can be compared: medians of repetitions taken in turn, so that what disturbs the machine for a
/// while disturbs all of them.

namespace credence::internal {

/// Which time is meant.
enum class TimedClock {
  thread,  ///< what the calling thread computed, whoever else uses the machine
  wall,    ///< for work that is shared over threads
};

/// Something to be timed: `work(n)` does it n times.
struct TimedWork {
  std::function<void(std::int64_t)> work;
  double items = 1.0;  ///< of one time; times are per item
  /// Costs recur with this period: a multiple of it is what a repetition does.
  std::int64_t period = 1;
  TimedClock clock = TimedClock::thread;
};

struct TimingPlan {
  int repetitions = 15;
  double seconds = 0.01;   ///< of one repetition, at least; the work is done as often as that takes
  std::uint64_t seed = 1;  ///< of the order within each repetition
};

/// The times of one work.
struct MeasuredTime {
  std::vector<double> repetitions;  ///< seconds per item
  double median = 0.0;
  /// Distribution-free interval of the median, by order statistics, of at least 95 %; the extremes when
  /// there are fewer than six repetitions, which is less.
  double lower = 0.0, upper = 0.0;
};

/// The median and its interval; throws std::invalid_argument for no repetitions.
MeasuredTime summarise_times(std::vector<double> repetitions);

/// Times all works in `plan.repetitions` rounds, each in another order and each work after one warming call.
///
/// `progress(done, total)` is called after every work of a round, the calibration being the first round; once
/// `stop` is set the rounds done are what is returned (none: empty). Throws std::invalid_argument for a plan
/// without repetitions or of no duration.
std::vector<MeasuredTime> time_interleaved(
    std::span<const TimedWork> works, const TimingPlan& plan, const std::atomic<bool>* stop = nullptr,
    const std::function<void(std::int64_t done, std::int64_t total)>& progress = {});

}  // namespace credence::internal
