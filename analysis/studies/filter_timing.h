#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "analysis/laws/power_law.h"
#include "analysis/studies/interleaved_timing.h"
#include "analysis/studies/machine.h"
#include "core/types.h"

/// @file
/// What a step costs against the size of the map, for the filters of the core, and what a Monte Carlo study
/// costs.

namespace credence::internal {

enum class TimedFilter {
  full,   ///< EkfSlam: dense P, each element of one triangle touched once an update
  naive,  ///< TextbookEkf: the textbook in Eigen, dense P, Joseph form
  map,    ///< BlockMapEkfSlam: map block diagonal, O(N), decorrelated after each scalar measurement
  batch,  ///< the same, decorrelated after each batch of them
};
inline constexpr std::array kTimedFilters{TimedFilter::full, TimedFilter::naive, TimedFilter::map,
                                          TimedFilter::batch};

/// "full", "naive", "map", "batch".
std::string_view to_string(TimedFilter filter);

struct FilterTimingPlan {
  /// Numbers of landmarks; each filter is timed up to what it can bear (largest_map).
  std::vector<Index> landmarks{10, 30, 100, 300, 1000, 2000, 3000, 10'000, 30'000, 100'000};
  std::vector<Index> observed{1, 10};  ///< landmarks seen in a step
  TimingPlan timing{};
};

/// The largest map that a filter is timed with: P alone is 1 GB at 5,600 landmarks.
Index largest_map(TimedFilter filter);

/// One step, predict and update, range and bearing.
struct FilterTime {
  TimedFilter filter = TimedFilter::full;
  Index landmarks = 0, observed = 0;
  MeasuredTime step;            ///< seconds
  std::optional<double> bytes;  ///< of heap that the filter holds; none where the system does not tell
};

/// How a filter's time grows with the map.
struct GrowthFit {
  TimedFilter filter = TimedFilter::full;
  Index observed = 0;
  Index from = 0;  ///< least N that is fitted: below it other costs than the map's matter
  int points = 0;
  PowerLaw law;
};

/// Where the O(N) filter `map` becomes faster than the full one, on the line between two measured sizes in
/// log-log scales; none when one of them is faster at all of them.
struct Crossover {
  Index observed = 0;
  std::optional<double> landmarks;
  TimedFilter faster_below = TimedFilter::full;  ///< at the smallest size
};

/// Seconds for one thing of a Monte Carlo study on one thread.
struct MonteCarloTimes {
  MeasuredTime step;            ///< one step of one run of the monobot, N = 1, NEES and NIS included
  MeasuredTime normal;          ///< one normal of its generator
  MeasuredTime reference_step;  ///< the same step by a plain loop with the standard library's normals
};

/// Seconds a run of the planar world, N = 10, by the engine.
struct ThreadScaling {
  int threads = 1;
  MeasuredTime run;
};

struct TimingResult {
  MachineDescription machine;
  TimingPlan plan;
  std::vector<FilterTime> filters;
  std::vector<GrowthFit> growth;
  std::vector<Crossover> crossovers;
  MonteCarloTimes monte_carlo;
  std::vector<ThreadScaling> scaling;
  bool complete = false;  ///< false: stopped; what was measured is there
};

/// Times all of it; a minute or so. Throws std::invalid_argument for a plan without landmarks, with numbers
/// below 1, or with no size at least as large as what is observed.
TimingResult time_filters(const FilterTimingPlan& plan, const std::atomic<bool>* stop = nullptr,
                          const std::function<void(std::int64_t done, std::int64_t total)>& progress = {});

/// Times the steps of the filters alone. Empty when stopped before the first round is done. Throws as
/// time_filters.
std::vector<FilterTime> time_filter_steps(const FilterTimingPlan& plan,
                                          const std::atomic<bool>* stop = nullptr);

/// Fits of all filters that have three sizes or more from their `from` on; for tests and reports.
std::vector<GrowthFit> fit_growth(std::span<const FilterTime> times);

/// For every number observed.
std::vector<Crossover> find_crossovers(std::span<const FilterTime> times);

}  // namespace credence::internal
