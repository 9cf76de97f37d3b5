#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "datasets/replay/carpark_long_horizon.h"
#include "datasets/replay/replay_result.h"

/// @file
/// The paper's Figures 5 to 8 and all their neighbours on the car park run: which inflation, by which bound,
/// with how many anchors, from which P0, and for how long.

namespace credence::internal {

/// One way to decorrelate.
struct CarparkVariant {
  Inflation inflation = Inflation::none;
  InflationSolution solution = InflationSolution::pairwise;  ///< of no effect without inflation
  Index anchors = 0;                                         ///< 0: partially observable

  bool operator==(const CarparkVariant&) const = default;
};

/// "none", "full, pairwise", "map, exact minimal trace", "map, sequential", "map, batch".
std::string inflation_words(const CarparkVariant& variant);
/// "partial", "1 anchor", "2 anchors".
std::string anchor_words(const CarparkVariant& variant);
/// "Figure 5", "Figure 6" or "Figure 7"; empty for the others.
std::string paper_figure(const CarparkVariant& variant);

struct InitialDeviations {
  double position_std = 0.05;  ///< m
  double heading_std_deg = 2;

  bool operator==(const InitialDeviations&) const = default;
};

struct CarparkVariantRun {
  CarparkVariant variant;
  InitialDeviations initial;
  ReplayResult result;
};

struct CarparkHorizonRun {
  CarparkVariant variant;
  LongHorizonResult result;
};

struct CarparkStudy {
  std::vector<CarparkVariantRun> runs;
  std::vector<CarparkHorizonRun> horizon;
  LongHorizonPlan plan;
  bool complete = true;  ///< false: stopped, and some results are empty

  /// Throws std::out_of_range when it was not replayed.
  const ReplayResult& find(const CarparkVariant& variant, const InitialDeviations& initial) const;
};

/// All variants: none, full and map; pairwise, exact minimal trace and, for the map, sequential and batch;
/// partial, one anchor, two anchors.
std::vector<CarparkVariant> carpark_variants();
/// The two P0 of which every variant is replayed.
std::vector<InitialDeviations> carpark_initials();
/// The P0 of 0.05 to 2 m and 2° to 15° of which the anchored variants without inflation and with the map's
/// are replayed.
std::vector<InitialDeviations> independence_initials();

struct CarparkStudyOptions {
  int threads = 0;                                    ///< 0: all of the machine
  const std::atomic<bool>* stop = nullptr;            ///< set: begin nothing more
  std::function<void(int done, int all)> progress{};  ///< called under a lock
  LongHorizonPlan plan{.loops = 10, .scan_stride = 10};
};

/// Replays all of it: about a minute of one core. Noise, sensor and start of `settings`; its inflation,
/// anchors and P0 are those of the variants. The same results for every number of threads. Throws as
/// replay_carpark.
CarparkStudy run_carpark_study(const CarparkLog& log, const ReplaySettings& settings,
                               const CarparkStudyOptions& options = {});

}  // namespace credence::internal
