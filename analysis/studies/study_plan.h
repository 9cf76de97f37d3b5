#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "analysis/laws/sample_size.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/scenario/scenario.h"

/// @file
/// How many runs a study needs, and how long it takes, before it is run.

namespace credence::internal {

/// What is asked of a study.
struct PlanQuestion {
  double factor = 1.2;      ///< true covariance / claimed P (NEES) or S (NIS), to be detected either way
  double power = 0.9;       ///< with this probability
  double precision = 0.05;  ///< relative half-width of the mean NEES
  int threads = 0;          ///< 0: one for each processor
  bool evidence = true;     ///< the first runs are looked at step by step, as by `run` and not by `sweep`
  const std::atomic<bool>* stop = nullptr;  ///< set: the pilot is dropped (Stopped)
};

/// How the correlation of NEES between steps became known.
enum class CorrelationSource {
  exact_law,   ///< of a linear filter (linear_run_law)
  pilot,       ///< measured on the runs of the pilot
  worst_case,  ///< not known: all steps taken as one
};

/// "exact law", "pilot" or "worst case".
std::string_view to_string(CorrelationSource source);

/// Runs that detect one factor.
struct DetectionPlan {
  double factor = 1.0;
  RunsNeeded needed;     ///< by the verdict alone
  RunsNeeded word;       ///< by its share of the word, the least that it can have
  double seconds = 0.0;  ///< expected, of the runs for the verdict alone
};

/// The plan of one of the two verdicts.
struct VerdictPlan {
  VerdictDesign design;
  std::vector<DetectionPlan> detections;  ///< of `factor` and 1/`factor`
  DetectableFactors detectable;           ///< with the runs that the scenario has
};

/// How long runs take here, from a short pilot.
struct PilotTiming {
  std::int64_t runs = 0;       ///< of the pilot
  double seconds = 0.0;        ///< that they took
  double seconds_per_run = 0;  ///< with all threads at work
  int threads = 0;
  std::int64_t evidence_runs = 0;         ///< of a study so many at most are looked at step by step
  double evidence_seconds_per_run = 0.0;  ///< that this takes beside

  double seconds_for(std::int64_t study_runs) const {
    return seconds_per_run * static_cast<double>(study_runs) +
           evidence_seconds_per_run * static_cast<double>(std::min(study_runs, evidence_runs));
  }
};

/// The plan of one configuration.
struct StudyPlan {
  Scenario scenario;
  PlanQuestion question;
  PilotTiming pilot;
  CorrelationSource correlation = CorrelationSource::worst_case;
  VerdictPlan nees, nis;
  std::int64_t runs_for_precision = 0;
  std::int64_t runs_for_all = 0;  ///< the most of all these
  double chunk_bytes = 0.0;       ///< that a store takes for a chunk of it
};

/// Throws std::invalid_argument, which names the option of `credence plan`, for a factor, power or precision
/// of which no pilot could tell anything.
void require_answerable(const PlanQuestion& question);

/// Plans the study of a scenario for the verdicts that `run` gives (judge_nees, judge_nis) at its confidence.
///
/// Runs a pilot of a tenth of the study's runs, of a linear world as many as are cheap, of 64 to 4096 runs,
/// fewer where these take longer than ten seconds: else the numbers but for the times depend on no clock. dof
/// per step are the mean over steps and runs of the pilot. The power is that of a filter whose errors are
/// those of factor · P at every step; verdict_power is a lower bound of it. Throws what require_answerable
/// throws, before it runs anything, and std::invalid_argument for a factor too near 1 and if every run of the
/// pilot fails at once; Stopped.
StudyPlan plan_study(const Scenario& scenario, const Experiment& experiment, const PlanQuestion& question);

/// What a whole sweep costs, all configurations with the same number of runs.
struct SweepCost {
  std::size_t configurations = 0, planned = 0;  ///< planned: those with a pilot; the others cost their mean
  std::int64_t runs = 0;                        ///< of each, the most that any of the planned needs
  double seconds = 0.0;
  std::int64_t scenario_runs = 0;  ///< of each, as the scenario has it
  double scenario_seconds = 0.0;
};

SweepCost sweep_cost(std::span<const StudyPlan> plans, std::size_t configurations);

/// What the runs of a scenario cost, on however many cores: the chunk is what cannot be divided.
struct JobCost {
  std::int64_t chunks = 0;     ///< of all configurations
  double chunk_seconds = 0.0;  ///< of one core, the mean
  double disk_bytes = 0.0;     ///< of stored results
  double memory_bytes = 0.0;   ///< of each process, at the least

  double core_seconds() const { return chunk_seconds * static_cast<double>(chunks); }
  /// With so many cores that have nothing else to do, and a writer that is never waited for.
  double seconds_on(std::int64_t cores) const {
    const std::int64_t rounds = (chunks + cores - 1) / cores;
    return chunk_seconds * static_cast<double>(rounds);
  }
};

/// Of all configurations, with the mean of those that were planned.
JobCost job_cost(std::span<const StudyPlan> plans, std::size_t configurations);

}  // namespace credence::internal
