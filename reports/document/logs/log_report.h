#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/calibration/calibration.h"
#include "analysis/evidence/study_analysis.h"
#include "datasets/logs/log_sink.h"
#include "datasets/logs/pose_facts.h"
#include "datasets/logs/run_errors.h"
#include "reports/document/document.h"

/// @file
/// What `credence check` says of a filter's logs.

namespace credence::internal {

/// Logs against those of an earlier version.
struct LogGate {
  std::string baseline;  ///< the file
  std::string verdict_before;
  double level = 0.05;                ///< up to which p-value a change is none of chance
  bool became_inconsistent = false;   ///< and was not before
  std::vector<FactorChange> changes;  ///< of the factor on P, on what both logged
  bool by_means = false;              ///< the changes are those of means, as there are no factors to pair
  std::string why_not;                ///< nothing could be compared: what is missing, and what to do
  std::int64_t runs_before = 0, missing_runs = 0;  ///< of the baseline's runs, those that are not here
  bool lost_more = false;          ///< a larger share of runs failed, or of rows was rejected, than before
  std::vector<std::string> worse;  ///< sentences: what fails

  /// Whether anything could be compared; else the word decides, as without a baseline.
  bool compares() const { return !changes.empty(); }
};

/// Logs and where they came from.
struct CheckedLogs {
  std::string name;                 ///< for titles and files
  std::string format;               ///< in words, with how truth was found
  std::int64_t files = 0;           ///< 0: the runs lay in memory
  std::int64_t unmatched_rows = 0;  ///< estimates without a truth at their time
  LogAnalysis analysis;
  std::vector<std::string> run_names{};                 ///< by number of the run; empty: not known
  std::map<std::int64_t, std::string> failures_said{};  ///< by number of the run: what its filter said
  std::vector<std::string> mistakes{};  ///< sentences: why errors misfit, by how they were logged
  std::vector<std::string> remarks{};   ///< sentences: what the reader left out, or took for something
  std::vector<LogPoses> poses{};        ///< of the files that hold some
  Calibration calibration{};
  UnitFactors units{};  ///< of it
  std::optional<LogGate> gate{};
  /// `optimistic` where the remarks say why it is so.
  Verdict explained = Verdict::undecided;
  RunErrors first_run{};  ///< of the first file; without steps where it was not kept

  /// `remarks`, and what the layout misses.
  std::vector<std::string> all_remarks() const;
  /// What to do: first of the mistakes, then what the judgement advises.
  std::vector<std::string> advice() const;
  /// What the factors on P are; of runs that alone are wrong none is, but whose they are.
  std::vector<std::string> factor_sentences() const;
};

/// What is wrong with the numbers themselves.
struct InputMistakes {
  Said said{};
  bool swapped_axes = false;  ///< that is what they say: runs are steps, and steps are runs
};

/// Judges what was collected of logs: their analysis, calibration and units. Where an error stays as it is
/// over whole runs (LawSums::errors_stand), or lasts for tenths of a few (StretchSums::stand), these are the
/// units of `calibration`. The factor on the whole P is that of the verdict on NEES, where it has one. Where
/// mistakes are named, what errors alone tell is no likely cause; of swapped axes nothing is judged.
void judge_collected(Evidence evidence, CalibrationUnits calibration, JudgementContext context,
                     InputMistakes mistakes, CheckedLogs& logs);

/// CheckedLogs::mistakes of what was said: not that errors misfit where NEES of all runs, and of their
/// blocks, is consistent, or that of all but a few that are lost. What tells of a misfit takes each run for
/// itself, and where a part of the errors stays over a whole run, most runs look as if P were too large.
std::vector<std::string> mistakes_told(Said said, const Judgement& judgement);

/// Where a mistake is named that makes errors misfit, drops the causes and the factor on P that these errors
/// alone tell.
void drop_explained_causes(Judgement& judgement);

/// What `credence check` says: the answer, verdicts on NEES, NIS, every block and every sensor, what was read
/// and what was rejected, what to do and what would mend it. JSON: docs/formats.md. Beside the page: NAME.csv
/// with every step.
Document log_document(CheckedLogs logs);

}  // namespace credence::internal
