#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/sums/recorded_run.h"
#include "datasets/replay/replay_result.h"

namespace credence::internal {

/// A replay to be shown.
struct ReportedReplay {
  ReplayResult result;
  /// The same with Jacobians at the truth, where there is one: what of the NEES is the EKF's linearisation.
  std::optional<ReplayResult> ideal;
};

/// What one replay, or several as independent runs, can tell; of a verdict that the data cannot support, why
/// not.
struct ReplayJudgement {
  RecordedNeesVerdict nees;  ///< position against GPS, or pose against motion capture; every second
  InnovationTests innovations;
  std::vector<MapConsistency> maps;  ///< of each run
  std::vector<std::string> limits;   ///< sentences: what is not judged, and what the tests assume
};

/// Judges replays of one data set with the same gate.
///
/// Without a gate the whitened observations of all batches are tested, which are independent under
/// consistency; with one the first observation of each batch alone, whose law is the truncated χ² exactly.
/// Throws std::invalid_argument for gates that differ.
ReplayJudgement judge_replays(std::span<const ReportedReplay> replays, double confidence = 0.95);

/// "carpark", "mrclam, robot 1".
std::string replay_name(const ReplayResult& result);

}  // namespace credence::internal
