#pragma once

#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario.h"
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
  bool complete = true;
  Document document;
};

/// Of logs, or of runs in memory.
Judged judged_logs(CheckedLogs logs);

/// Of a study of our own.
Judged judged_study(ReportedStudy study);

/// Judges a scenario by its runs, and by what explains them: the further tests and the bound on the errors,
/// which `further` is for. Throws as judge_scenario.
JudgedFilter judge_study(const Scenario& scenario, const EngineOptions& runs, const EngineOptions& further);

}  // namespace credence::internal
