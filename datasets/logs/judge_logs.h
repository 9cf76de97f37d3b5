#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "analysis/calibration/calibration_sums.h"
#include "analysis/evidence/sums/evidence_recorder.h"
#include "analysis/evidence/verdicts/step_times.h"
#include "datasets/judged_states.h"
#include "datasets/logs/log_sink.h"
#include "datasets/logs/rounded_copies.h"

namespace credence::internal {

/// Reads one file and hands over its runs. Throws DataError.
using LogFileReader = std::function<void(const std::filesystem::path& file, LogSink& sink)>;

struct LogJudgeOptions {
  int threads = 0;                                   ///< 0: one for each processor
  const std::atomic<bool>* stop = nullptr;           ///< set: what was read is judged
  std::function<void(std::int64_t bytes)> progress;  ///< bytes read so far, by one thread at a time
  /// Of a file that is cut off or corrupted what comes before is judged, with a remark, if it is anything.
  bool partial = false;
};

/// What a reader had to say of a file.
struct LogRemark {
  /// Those of LogSink: of a mistake are all but the first, and perhaps chance are misfits and hints.
  enum class Kind { remark, misfit, hint, mistake };

  std::filesystem::path file;
  std::string sentence;
  Kind kind = Kind::remark;

  bool may_be_chance() const { return kind == Kind::misfit || kind == Kind::hint; }
};

/// What was read.
struct LogJudgeResult {
  Evidence evidence;
  std::int64_t files = 0;
  std::int64_t unmatched_rows = 0;      ///< estimates without a truth at their time
  TruthFit truth_fit = TruthFit::none;  ///< the worst of all files
  /// In the order of the files. Of hints the first alone, and only where more files have one than chance
  /// explains and than misfit without one.
  std::vector<LogRemark> remarks;
  std::vector<LogPoses> poses{};         ///< of the files that hold some, in their order
  std::vector<std::string> run_names{};  ///< of all, without folder and ending (run_name.h)
  CopiedRuns copies{};
  JudgedStates judged{};
  CalibrationUnits calibration{};
  StepTimes times{};
  bool complete = true;
  bool swapped_axes = false;  ///< LogSink::swapped_axes of a file

  /// A remark says why P misfits: that its scale is wrong is then no cause.
  bool explained() const;
};

/// Reads the files in parallel, with memory for a few groups of them; of fewer groups than threads each is
/// read while it is added up (read_ahead.h).
///
/// Files are taken 64 at a time, and runs are added up 64 at a time, in their order: logs of one run each
/// give the bits of a study of our own (kChunkRuns), whatever the number of threads. Throws the error of the
/// first bad file in order; and DataError for a run that is there twice (run_fingerprints.h).
LogJudgeResult judge_logs(std::span<const std::filesystem::path> files, const LogFileReader& read,
                          const LogJudgeOptions& options);

}  // namespace credence::internal
