#include <algorithm>
#include <cmath>
#include <set>

#include "analysis/studies/filter_timing.h"

namespace credence::internal {
namespace {

/// From where on the map's share of the cost outweighs all else.
Index fitted_from(TimedFilter filter) {
  switch (filter) {
    case TimedFilter::full: return 300;
    case TimedFilter::naive: return 100;
    case TimedFilter::map: return 1000;
    case TimedFilter::batch: return 10'000;
  }
  return 1;
}

std::set<Index> observed_numbers(std::span<const FilterTime> times) {
  std::set<Index> observed;
  for (const FilterTime& time : times) observed.insert(time.observed);
  return observed;
}

/// Times of one filter, by rising N.
std::vector<FilterTime> times_of(std::span<const FilterTime> times, TimedFilter filter, Index observed) {
  std::vector<FilterTime> chosen;
  for (const FilterTime& time : times) {
    if (time.filter == filter && time.observed == observed) chosen.push_back(time);
  }
  std::ranges::sort(chosen, {}, &FilterTime::landmarks);
  return chosen;
}

}  // namespace

std::vector<GrowthFit> fit_growth(std::span<const FilterTime> times) {
  std::vector<GrowthFit> fits;
  for (const TimedFilter filter : kTimedFilters) {
    for (const Index observed : observed_numbers(times)) {
      std::vector<double> landmarks, seconds;
      for (const FilterTime& time : times_of(times, filter, observed)) {
        if (time.landmarks < fitted_from(filter)) continue;
        landmarks.push_back(static_cast<double>(time.landmarks));
        seconds.push_back(time.step.median);
      }
      if (landmarks.size() < 3) continue;
      fits.push_back({filter, observed, fitted_from(filter), static_cast<int>(landmarks.size()),
                      fit_power_law(landmarks, seconds)});
    }
  }
  return fits;
}

std::vector<Crossover> find_crossovers(std::span<const FilterTime> times) {
  std::vector<Crossover> crossovers;
  for (const Index observed : observed_numbers(times)) {
    const std::vector<FilterTime> map = times_of(times, TimedFilter::map, observed);
    std::vector<double> log_n, log_ratio;  // of full / map, where both are measured
    for (const FilterTime& full : times_of(times, TimedFilter::full, observed)) {
      const auto same = std::ranges::find(map, full.landmarks, &FilterTime::landmarks);
      if (same == map.end()) continue;
      log_n.push_back(std::log(static_cast<double>(full.landmarks)));
      log_ratio.push_back(std::log(full.step.median / same->step.median));
    }
    if (log_n.empty()) continue;
    Crossover crossover{.observed = observed,
                        .landmarks = {},
                        .faster_below = log_ratio.front() < 0.0 ? TimedFilter::full : TimedFilter::map};
    for (std::size_t i = 1; i < log_n.size(); ++i) {
      if (!(log_ratio[i - 1] < 0.0 && log_ratio[i] >= 0.0)) continue;
      const double t = log_ratio[i - 1] / (log_ratio[i - 1] - log_ratio[i]);
      crossover.landmarks = std::exp(log_n[i - 1] + t * (log_n[i] - log_n[i - 1]));
    }
    crossovers.push_back(crossover);
  }
  return crossovers;
}

}  // namespace credence::internal
