#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/verdicts/map_consistency.h"
#include "analysis/tuning/noise_scale.h"
#include "datasets/replay/replay_result.h"
#include "reports/document/logs/log_report.h"

namespace credence::internal {

/// A replay to be shown.
struct ReportedReplay {
  ReplayResult result;
  /// The same with Jacobians at the truth, where there is one: what of the NEES is the EKF's linearisation.
  std::optional<ReplayResult> ideal;
};

/// What one replay, or several as independent runs, can tell.
struct ReplayJudgement {
  CheckedLogs logs;                  ///< judged as logs are; its remarks are the limits
  NoiseScale noise_scale;            ///< as innovations of a replay are hardly white
  std::vector<MapConsistency> maps;  ///< of each run
};

/// Judges replays of one data set as the logs that read_replay makes of them, within the gate that they have.
/// Throws std::invalid_argument for gates that differ, and DataError for a run that is there twice.
ReplayJudgement judge_replays(std::span<const ReportedReplay> replays);

/// "carpark", "mrclam, robot 1".
std::string replay_name(const ReplayResult& result);

}  // namespace credence::internal
