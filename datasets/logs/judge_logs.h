#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "analysis/evidence/evidence_recorder.h"

namespace credence {

/// Reads one file and hands its rows, run by run, to the accumulator; `advance` is told, now and then, how
/// many bytes more were read. Throws DataError.
using LogFileReader = std::function<void(const std::filesystem::path& file, EvidenceRecorder& sums,
                                         const std::function<void(std::int64_t bytes)>& advance)>;

/// Adds the rows of a log in the project's own format.
void read_own_log(const std::filesystem::path& file, EvidenceRecorder& sums,
                  const std::function<void(std::int64_t)>& advance);

struct LogJudgeOptions {
  int threads = 0;                                   ///< 0: one for each processor
  const std::atomic<bool>* stop = nullptr;           ///< set: the groups in hand are dropped
  std::function<void(std::int64_t bytes)> progress;  ///< bytes read so far, by one thread at a time
};

/// What was read.
struct LogJudgeResult {
  Evidence evidence;
  std::int64_t files = 0;
  bool complete = true;
};

/// Reads the files in parallel, with memory for a few groups of them.
///
/// Files are taken 64 at a time, and runs are added up 64 at a time, in their order: logs of one run each
/// give the bits of a study of our own (kChunkRuns), whatever the number of threads. Throws the DataError of
/// the first bad file in order.
LogJudgeResult judge_logs(std::span<const std::filesystem::path> files, const LogFileReader& read,
                          const LogJudgeOptions& options);

/// The files that arguments mean: a file itself, of a folder its *.csv (in the order of their names).
/// Throws DataError for a folder without any, and for a file that is there twice.
std::vector<std::filesystem::path> log_files(std::span<const std::string> arguments);

}  // namespace credence
