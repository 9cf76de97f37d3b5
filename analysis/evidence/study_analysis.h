#pragma once

#include <optional>
#include <vector>

#include "analysis/evidence/sequential/sequential.h"
#include "analysis/evidence/sums/evidence_collect.h"
#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/evidence/verdicts/judgement.h"
#include "analysis/stability/exact_moments.h"
#include "core/types.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario.h"

/// @file
/// From the sums of a study to what is reported of it: verdicts, covariance curves, outcomes.

namespace credence::internal {

/// Mean traces of the filter's covariance at steps 1 … T.
struct CovarianceCurves {
  std::vector<double> trace_prior;  ///< before the update, after the inflation
  std::vector<double> trace;        ///< after the update
  std::vector<double> vehicle;      ///< position of the vehicle
  std::vector<double> landmarks;    ///< all landmarks in the state
  std::vector<double> heading;      ///< rad²
  std::vector<double> landmark;     ///< mean over the landmarks in the state
};

/// Root mean squared errors over the runs at steps 1 … T; empty for linear models, where Σ is exact.
struct ErrorCurves {
  std::vector<double> position_m, heading_rad, landmark_m;
};

/// One configuration, judged.
struct StudyAnalysis {
  Scenario scenario;
  StudyStatistics statistics;
  bool complete = true;              ///< false: interrupted: fewer runs than asked for, or not all tests
  bool timed_out = false;            ///< ended by study.stop.max_seconds
  std::optional<StopDecision> stop;  ///< with a stop rule: the last look
  Index state_dim = 0;               ///< of the complete map
  ConsistencyVerdict nees, nis;
  std::optional<ConsistencyVerdict> vehicle_nees;  ///< planar: the pose alone
  Word word;                            ///< over NEES, NIS and the pose, or all blocks with a judgement
  std::optional<Judgement> judgement;   ///< of the first runs; not made for a sweep
  std::optional<PosteriorBound> bound;  ///< with a judgement, of a world that is not linear
  CovarianceCurves covariance;
  ErrorCurves errors;
  bool linear = false;              ///< gains and errors are linear: `exact` and `gain` may be known
  std::vector<ExactMoments> exact;  ///< linear models: one for each step
  Matrix gain;                      ///< linear models: K of the last step, n×m
};

/// Judges the result of one configuration, which `experiment` produced.
///
/// stop: the last look of a study with a stop rule, whose verdict then takes the place of those of NEES and
/// NIS, which hold their level only when the number of runs was fixed in advance.
StudyAnalysis analyse_study(const Scenario& scenario, const Experiment& experiment, StudyResult result,
                            const std::optional<StopDecision>& stop = std::nullopt);

/// At the last look, whose number of runs was set in advance, all tests together have the half of α that the
/// e-values have left: `stop` takes their word.
void take_word_of_last_look(const Word& word, double confidence, StopDecision& stop);

/// Runs of a study of so many that its further evidence is taken of.
std::int64_t evidence_runs(const Scenario& scenario, std::int64_t runs);

/// Adds what the evidence of the first runs (evidence_runs) says, unless it is stopped and so not complete.
/// `options` as for EvidenceCollector::take.
void add_judgement(StudyAnalysis& analysis, EvidenceCollector& evidence, const EngineOptions& options = {});
/// Plays these runs for it.
void add_judgement(StudyAnalysis& analysis, const Experiment& experiment, const EngineOptions& options = {});

/// Adds what no filter's error is below in this world, if it is not linear and has a judgement, unless it is
/// stopped and so not complete.
void add_posterior_bound(StudyAnalysis& analysis, const EngineOptions& options = {});

/// The one word: that over NEES, NIS and the blocks. With a stop rule that of the rule (at the last look the
/// word by half of α), but: undecided where the rule proves the mean of NEES and the word rejects, which it
/// may of runs that chose their own number; and not Gaussian as the word has it, since steps and innovations
/// are judged by the χ² law.
Verdict overall_verdict(const StudyAnalysis& analysis);
/// The p-value of that word: of a stop rule valid at any look.
double overall_p_value(const StudyAnalysis& analysis);
/// What it says; of a stop rule what the word over all says where it is the same, else why it is not, if that
/// is told.
std::string overall_says(const StudyAnalysis& analysis);

/// Logs of a filter, judged.
struct LogAnalysis {
  Evidence evidence;
  Judgement judgement;
  bool complete = true;                   ///< false: interrupted
  CovarianceCurves covariance;            ///< without trace_prior, which a log does not hold
  ErrorCurves errors;                     ///< of a position, a heading and a map, where there are such blocks
  std::optional<PosteriorBound> bound{};  ///< of runs in a world that is known
};

/// Judges logs: the same sums as a study of our own give the same numbers. Of `context` all but all_runs
/// counts.
LogAnalysis analyse_logs(Evidence evidence, const JudgementContext& context);

}  // namespace credence::internal
