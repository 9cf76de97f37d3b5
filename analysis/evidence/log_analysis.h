#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evidence/advice.h"
#include "analysis/evidence/consistency.h"
#include "analysis/evidence/log_statistics.h"
#include "analysis/evidence/study_analysis.h"
#include "analysis/laws/effective_sample.h"
#include "analysis/laws/goodness_of_fit.h"
#include "analysis/laws/whiteness.h"
#include "analysis/laws/whiteness_innovation_mean.h"

/// @file
/// From the sums over a filter's logs to verdicts: those of a study of our own, and what a log can tell
/// besides.

namespace credence {

/// A single run, whose NEES is correlated in time (theory, section 7).
struct SingleRunAnalysis {
  TimeAverageTest time_average;  ///< of NEES / dof over the run
  EffectiveSample sample;        ///< in rows
  SettlingRuns settling;         ///< runs like this one that would decide
};

/// The innovations of one sensor.
struct SensorAnalysis {
  std::string name;
  ConsistencyVerdict nis;
  WhitenessTest whiteness;
  InnovationMeanTest mean;
  bool of_sum = false;  ///< whiteness and mean are of Σ u_i/√m, as the dimension varies
};

/// The verdicts without gross outliers, beside those with them.
struct SensitivityAnalysis {
  std::int64_t nees_outliers = 0, nis_outliers = 0;
  ConsistencyVerdict nees, nis;
};

/// The logs of one filter, judged.
struct LogAnalysis {
  LogStatistics statistics;
  double confidence = 0.95;
  bool complete = true;  ///< false: interrupted
  ConsistencyVerdict nees, nis;
  std::optional<ConsistencyVerdict> vehicle_nees;  ///< of a block named "vehicle"
  std::vector<BlockVerdict> blocks;                ///< marginal NEES; empty if there is but one block
  ResponsibleBlock responsible;
  std::vector<SensorAnalysis> sensors;
  GoodnessOfFit fit;  ///< of all NIS against χ²
  std::optional<SingleRunAnalysis> single;
  std::optional<SensitivityAnalysis> sensitivity;
  CovarianceCurves covariance;  ///< without trace_prior, which a log does not hold
  ErrorCurves errors;           ///< of a vehicle and landmarks in the plane, else empty
};

/// Judges logs. Verdicts on several runs are those of analyse_study: the same sums give the same numbers.
///
/// One run: the verdict on NEES joins, by the union bound at half the level each, that for any correlation in
/// time and the test of the run's average over nearly independent stretches; where the run is too short for
/// the latter and nothing rejects, it is undecided, with the runs that would settle it. Covariances between
/// blocks unknown: the sum of their NEES is tested by a bound for every dependence.
LogAnalysis analyse_logs(LogStatistics statistics, double confidence, bool sensitivity);

/// What NEES says, or NIS where NEES is consistent or there is no truth; undecided when either is and the
/// other does not reject.
Verdict overall_verdict(const LogAnalysis& analysis);

}  // namespace credence
