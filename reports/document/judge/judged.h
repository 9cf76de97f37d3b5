#pragma once

#include <atomic>

#include "analysis/evidence/configuration.h"
#include "montecarlo/engine/engine.h"
#include "reports/document/document.h"
#include "reports/document/judge/judged_filter.h"
#include "reports/document/logs/log_report.h"
#include "reports/document/study/study_report.h"

namespace credence::internal {

/// What a JudgedFilter tells.
struct Judged {
  Verdict verdict = Verdict::undecided;
  double p_value = 0.0;
  std::string says;
  Factor factor;
  std::vector<NamedCause> causes;
  std::vector<FailedRun> failures;
  std::vector<std::string> mistakes;
  bool complete = true;
  Document document;
};

/// Of logs, or of runs in memory.
Judged judged_logs(CheckedLogs logs);

/// Of a study of our own.
Judged judged_study(ReportedStudy study);

/// Judges a configuration by the runs that were played of it, and by what explains them: the further tests
/// and the bound on the errors, which `further` is for. Throws std::runtime_error where there are no runs.
JudgedFilter judge_played(const Configuration& configuration, PlayedStudy played,
                          const EngineOptions& further);

/// How the engine is told of the options of a judgement.
EngineOptions engine_options(int threads, const std::atomic<bool>* stop, const JudgeProgress& progress = {});

}  // namespace credence::internal
