#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evidence/causes/advice.h"
#include "analysis/evidence/causes/advice_cause.h"
#include "analysis/evidence/causes/lost_runs.h"
#include "analysis/evidence/sums/evidence.h"
#include "analysis/evidence/verdicts/accuracy.h"
#include "analysis/evidence/verdicts/claimed_sigma.h"
#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/evidence/verdicts/law_judgement.h"
#include "analysis/evidence/verdicts/truth_fit.h"
#include "analysis/evidence/verdicts/word.h"
#include "analysis/laws/correlation/error_correlation.h"
#include "analysis/laws/correlation/modulation.h"
#include "analysis/laws/correlation/square_correlation.h"
#include "analysis/laws/correlation/whiteness.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/zero_mean.h"
#include "analysis/laws/scores/credibility.h"
#include "analysis/laws/scores/rmse_interval.h"
#include "analysis/laws/shape/component_variances.h"
#include "analysis/laws/shape/coverage.h"
#include "analysis/laws/shape/goodness_of_fit.h"
#include "core/nan.h"

/// @file
/// What the evidence says of a filter, beside the verdicts on NEES and NIS: where an inconsistency sits, what
/// causes it, and what would mend it (theory, section 7). The same for a study of our own, for logs, for a
/// replay and for the selftest, which measures what each of these tests does to a consistent filter. Each
/// test holds its own false-alarm rate, and `adjusted` tells which of them still speak when all are taken
/// together.

namespace credence::internal {

/// How near the false-alarm rate of a test is to its level.
enum class Exactness {
  exact,         ///< equal
  approximate,   ///< nearly equal: a limit law, or matched cumulants
  conservative,  ///< at most: by proof or, of averages of whole runs, to the precision of run_mean.h
};

/// "exact", "approximate" or "conservative".
std::string_view to_string(Exactness exactness);

/// One line of the test suite.
struct NamedTest {
  std::string name;
  Exactness exactness = Exactness::conservative;
  double p_value = 0.0;   ///< of this test alone; NaN: not made
  double adjusted = 0.0;  ///< Holm's over the whole suite
  std::string says;       ///< in words, the number included
};

/// The innovations of one sensor.
struct SensorJudgement {
  std::string name;
  ConsistencyVerdict nis;
  WhitenessTest whiteness;
  ZeroMeanTest mean;  ///< of run means; of all values where there are too few runs (correlated_mean.h)
  ComponentTest components, pairs;        ///< each component, and every two of them (SensorSums::pairs)
  SquareCorrelation correlation;          ///< in time, of innovations that are not white
  Modulation over_time;                   ///< of NIS of few runs (nis_over_time); `wave` in steps
  bool of_sum = false;                    ///< whiteness and mean are of Σ u_i/√m, as the dimension varies
  GoodnessOfFit fit;                      ///< of NIS against χ²
  std::vector<std::int64_t> histogram;    ///< counts of F(NIS), equally likely bins
  std::optional<GateFound> gate;          ///< of which `nis` takes the law cut off there
  std::optional<GateFound> perhaps_gate;  ///< of too few missing values, or as well an S that is too large
};

/// A single run, whose NEES is correlated in time (theory, section 7).
struct SingleRunJudgement {
  TimeAverageTest time_average;  ///< of NEES / dof over the run
  EffectiveSample sample;        ///< in rows
  double rows_needed = kNaN;     ///< of a run like it, for its average to be tested
};

/// The verdicts without gross outliers, beside those with them.
struct SensitivityJudgement {
  std::int64_t nees_outliers = 0, nis_outliers = 0;
  ConsistencyVerdict nees, nis;
};

/// The evidence, judged.
struct Judgement {
  std::int64_t runs = 0;  ///< that it rests on: of a study the first ones
  double confidence = 0.95;
  std::int64_t step_stride = 1;                    ///< of the coverage, the blocks and the sensors
  ConsistencyVerdict nees, nis;                    ///< of all runs of a study
  std::optional<ConsistencyVerdict> vehicle_nees;  ///< of a block that is a pose, of all runs too
  Word word;                                       ///< over NEES, NIS, the blocks and directions
  std::vector<BlockVerdict> blocks;                ///< empty if the whole state is one block
  ResponsibleBlock responsible;
  std::vector<NeesOverTime> nees_over_time{};  ///< of few runs
  ClaimedSigmaTest claimed_sigma;
  LostRuns lost;  ///< runs that alone are wrong; empty where the word is not inconsistent
  std::vector<SensorJudgement> sensors;
  std::array<CoverageVerdict, CoverageSums::kSigmas.size()> coverage;
  CredibilityIndex credibility;              ///< of the pose, or the first block, at the last step
  ErrorCorrelationTest error_correlation;    ///< of the whole state at the last step
  LawJudgement law;                          ///< every direction of P, and the law of the errors
  RmseInterval position, heading, landmark;  ///< averaged over the steps
  std::vector<BlockAccuracy> accuracy;       ///< of a study with its bound
  double effective_steps = 0.0;  ///< independent steps that the NEES of a run is worth; NaN: not known
  ScaleAdvice scale_covariance, scale_innovation, scale_measurement_noise;
  SettlingRuns settle_nees, settle_nis;
  std::vector<CauseFound> causes;
  std::vector<NamedTest> tests;
  std::optional<SingleRunJudgement> single;
  std::optional<SensitivityJudgement> sensitivity;
};

/// What the judge knows besides the evidence.
struct JudgementContext {
  double confidence = 0.95;
  bool sensitivity = false;  ///< also judge without gross outliers
  double margin = 0.1;       ///< of what is proved: the factor on P is between 1/(1 + this) and 1 + this
  TruthFit truth_fit = TruthFit::none;
  /// The sums of all runs of a study, of which the evidence is of the first ones; none: the evidence is all.
  const StudyStatistics* all_runs = nullptr;
  /// Innovations of a larger NIS are left out, as whoever made the evidence knows: all are of one sensor and
  /// of one dimension.
  double gate = std::numeric_limits<double>::infinity();
  /// The factor on S, where more is known of it than that the innovations are white.
  std::optional<ScaleAdvice> scale_innovation{};
  std::optional<double> memory{};            ///< memory_in_rows of the evidence, where it is known already
  ClaimedSigmaTest claimed_sigma{};          ///< of the rows of these runs
  std::shared_ptr<const StepTimes> times{};  ///< of the runs; null: not known
  /// Of each run of the evidence, where its number among them is not how it can be found.
  std::vector<std::string> run_names{};
  /// Of runs so many of which are nearly the same as another one that this is the cause of all that is found:
  /// what is told of them.
  std::string copies{};
};

/// Judges the sums.
///
/// One run: the verdict on NEES joins, by the union bound at half the level each, that for any correlation in
/// time and the test of the run's average over nearly independent stretches; where the run is too short for
/// the latter, or an error stays as it is all along, and nothing rejects, it is undecided, with the runs that
/// would settle it. Covariances between blocks unknown: the sum of their NEES is tested by a bound for every
/// dependence; so is the sum of the NIS of several sensors, of which the word takes each alone.
///
/// Where only tests that need a Gaussian law reject, and the tails are heavy, the word is `not_gaussian`; not
/// where a few runs are lost, or mean squares are known too poorly to say that P is right.
Judgement judge(const Evidence& evidence, const JudgementContext& context = {});

/// The verdict on the NEES of the pose; none where the study has no pose.
std::optional<ConsistencyVerdict> judge_vehicle(const StudyStatistics& statistics, double confidence);

}  // namespace credence::internal
