#pragma once

#include "analysis/studies/selftest_study.h"
#include "reports/document/logs/log_report.h"

namespace credence::internal {

/// The logs of 32 runs of the selftest's filter, 40 steps each: states heading and landmark, two blocks, a
/// compass and a landmark's bearing.
inline CheckedLogs synthetic_logs(Defect defect) {
  CheckedLogs logs;
  CalibrationRecorder recorder;
  logs.analysis = analyse_logs(synthetic_evidence(SyntheticFilter(setup_of(defect)), NoiseSource(4, 1), 0,
                                                  SyntheticFilter::kRuns, SyntheticFilter::kSteps, &recorder),
                               {});
  logs.calibration = judge_calibration(recorder, 0.95);
  logs.name = "my logs";
  logs.format = "CSV";
  logs.files = 32;
  return logs;
}

/// What the reader of poses found in one file.
inline LogPoses synthetic_poses() {
  LogPoses poses;
  poses.file = "folder/run.csv";
  poses.charts.declared = "right";
  poses.charts.rows = 100;
  poses.charts.charts = {{.chart = "left", .as_written = 9.5, .p_value = 1e-4, .carried = 6.25},
                         {.chart = "right", .as_written = 6.125, .carried = 6.125}};
  poses.time_offset =
      TimeOffset{.value_s = 0.5, .lower_s = 0.25, .upper_s = 0.75, .estimated = true, .rows = 90};
  return poses;
}

}  // namespace credence::internal
