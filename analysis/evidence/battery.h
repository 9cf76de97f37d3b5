#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evidence/advice.h"
#include "analysis/evidence/advice_cause.h"
#include "analysis/evidence/battery_statistics.h"
#include "analysis/evidence/consistency.h"
#include "analysis/laws/coverage.h"
#include "analysis/laws/credibility.h"
#include "analysis/laws/credibility_rmse.h"
#include "analysis/laws/effective_sample.h"
#include "analysis/laws/goodness_of_fit.h"
#include "analysis/laws/whiteness.h"
#include "analysis/laws/whiteness_innovation_mean.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/scenario/scenario.h"

/// @file
/// What the whole battery (theory, section 7) says of a filter, beside the two verdicts on NEES and NIS:
/// where an inconsistency sits, what causes it, and what would mend it. These tests explain a verdict; each
/// holds its own false-alarm rate, and `adjusted` tells which of them still speak when all are taken
/// together.

namespace credence {

/// One line of the battery.
struct BatteryTest {
  std::string name;
  double p_value = 0.0;   ///< of this test alone; NaN: not made
  double adjusted = 0.0;  ///< Holm's over the whole battery
  std::string says;       ///< in words, the number included
};

/// The battery, judged.
struct Battery {
  std::int64_t runs = 0;  ///< that it rests on: the first ones of the study
  double confidence = 0.95;
  std::vector<BlockVerdict> blocks;
  ResponsibleBlock responsible;
  GoodnessOfFit nis_fit;
  std::vector<std::int64_t> nis_histogram;  ///< counts of F(NIS), equally likely bins
  WhitenessTest whiteness;
  InnovationMeanTest innovation_mean;
  std::array<CoverageVerdict, CoverageStatistics::kSigmas.size()> coverage;
  CredibilityIndex credibility;                         ///< of the vehicle at the last step
  std::array<RmseInterval, RunStatistics::parts> rmse;  ///< averaged over the steps
  double effective_steps = 0.0;  ///< independent steps that the NEES of a run is worth; NaN: not known
  ScaleAdvice scale_covariance, scale_innovation, scale_measurement_noise;
  SettlingRuns settle_nees, settle_nis;
  std::vector<CauseFound> causes;
  std::vector<BatteryTest> tests;
};

/// Runs of a study that the battery looks at: at most 1,024, fewer where a state is large, and whole chunks.
///
/// Every run is played again in full for it, so the number is bounded by what that costs.
std::int64_t battery_runs(const Scenario& scenario, std::int64_t runs);

/// Plays the first `runs` runs and accumulates; the bits do not depend on the threads. Of `options` only
/// threads, stop and progress count. Nothing when stopped: a battery of some of the runs would not be the
/// same twice.
std::optional<BatteryStatistics> collect_battery(const Scenario& scenario, const Experiment& experiment,
                                                 std::int64_t runs, const EngineOptions& options = {});

/// Judges the sums. nees, nis: the verdicts of the study that they explain.
Battery judge_battery(const BatteryStatistics& statistics, const ConsistencyVerdict& nees,
                      const ConsistencyVerdict& nis);

}  // namespace credence
