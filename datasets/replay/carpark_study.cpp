#include "datasets/replay/carpark_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>

#include "core/append_item.h"
#include "core/inflation/inflation_rule.h"
#include "core/parallel_tasks.h"
#include "datasets/replay/carpark_replay.h"

namespace credence::internal {
namespace {

using enum Inflation;
using enum InflationSolution;

ReplaySettings settings_of(ReplaySettings settings, const CarparkVariant& variant,
                           const InitialDeviations& initial) {
  settings.filter.inflation = variant.inflation;
  settings.filter.solution = variant.solution;
  settings.world.full = variant.anchors > 0;
  settings.world.anchors = std::max<Index>(1, variant.anchors);
  settings.initial.position_std = initial.position_std;
  settings.initial.heading_std_deg = initial.heading_std_deg;
  return settings;
}

bool is_in_independence(const CarparkVariant& variant) {
  const bool inflation =
      variant.inflation == none || (variant.inflation == map && !map_bound(variant.solution).has_value());
  return inflation && variant.anchors > 0;
}

}  // namespace

std::string inflation_words(const CarparkVariant& variant) {
  if (variant.inflation == none) return "none";
  const char* set = variant.inflation == full ? "full" : "map";
  const char* bound = variant.solution == pairwise     ? "pairwise"
                      : variant.solution == min_trace  ? "exact minimal trace"
                      : variant.solution == sequential ? "sequential"
                                                       : "batch";
  return fmt::format("{}, {}", set, bound);
}

std::string anchor_words(const CarparkVariant& variant) {
  if (variant.anchors == 0) return "partial";
  return counted(variant.anchors, "anchor");
}

std::string paper_figure(const CarparkVariant& variant) {
  if (map_bound(variant.solution).has_value()) return "";  // the paper has none within the update
  if (variant.inflation == full && variant.anchors == 0) return "Figure 5";
  if (variant.inflation == map && variant.anchors == 0) return "Figure 6";
  if (variant.inflation == map && variant.anchors == 1) return "Figure 7";
  return "";
}

std::vector<CarparkVariant> carpark_variants() {
  std::vector<CarparkVariant> variants;
  for (const Index anchors : {0, 1, 2}) {
    variants.push_back({none, pairwise, anchors});
    for (const Inflation inflation : {full, map})
      for (const InflationSolution solution : {pairwise, min_trace})
        variants.push_back({inflation, solution, anchors});
    for (const InflationSolution solution : {sequential, batch}) {
      variants.push_back({map, solution, anchors});
    }
  }
  return variants;
}

std::vector<InitialDeviations> carpark_initials() { return {{0.05, 2}, {0.316, 15}}; }

std::vector<InitialDeviations> independence_initials() {
  return {{0.05, 2}, {0.05, 15}, {0.316, 15}, {2, 2}, {2, 15}};
}

const ReplayResult& CarparkStudy::find(const CarparkVariant& variant,
                                       const InitialDeviations& initial) const {
  for (const CarparkVariantRun& run : runs)
    if (run.variant == variant && run.initial == initial) return run.result;
  throw std::out_of_range(fmt::format("no replay of {}, {}, P0 of {} m and {} degrees",
                                      inflation_words(variant), anchor_words(variant), initial.position_std,
                                      initial.heading_std_deg));
}

CarparkStudy run_carpark_study(const CarparkLog& log, const ReplaySettings& settings,
                               const CarparkStudyOptions& options) {
  CarparkStudy study;
  study.plan = options.plan;
  const std::vector<InitialDeviations> both = carpark_initials();
  for (const CarparkVariant& variant : carpark_variants()) {
    for (const InitialDeviations& initial : both) study.runs.push_back({variant, initial, {}});
    if (!is_in_independence(variant)) continue;
    for (const InitialDeviations& initial : independence_initials())
      if (std::ranges::find(both, initial) == both.end()) study.runs.push_back({variant, initial, {}});
  }
  for (const CarparkVariant& variant : carpark_variants())
    if (variant.anchors == 0) study.horizon.push_back({variant, {}});

  const std::vector<ScanObservations> scans = carpark_scans(log);
  const int replays = static_cast<int>(study.runs.size()), horizons = static_cast<int>(study.horizon.size());
  // The long ones first, so that no thread waits for one begun last.
  const auto task = [&](int i) {
    if (i < horizons) {
      CarparkHorizonRun& run = study.horizon[static_cast<std::size_t>(i)];
      run.result = carpark_long_horizon(log, settings_of(settings, run.variant, both.front()), options.plan);
    } else {
      CarparkVariantRun& run = study.runs[static_cast<std::size_t>(i - horizons)];
      run.result = replay_carpark(log, scans, settings_of(settings, run.variant, run.initial));
    }
  };
  std::mutex mutex;
  int done = 0;
  for_each_task(replays + horizons, options.threads, options.stop, [&](std::int64_t i) {
    task(static_cast<int>(i));
    const std::lock_guard lock(mutex);
    ++done;
    if (options.progress) options.progress(done, replays + horizons);
  });
  study.complete = done == replays + horizons;
  return study;
}

}  // namespace credence::internal
