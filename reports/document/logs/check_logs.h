#pragma once

#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "datasets/logs/log_read_options.h"
#include "reports/document/judge/judged_filter.h"

namespace credence {

/// How logs are read and judged (docs/logs.md).
struct CheckOptions {
  std::string name{};                 ///< for titles and files; "" for that of the first log
  std::string format = "auto";        ///< seen from how a file begins, or a name of log_formats
  std::vector<std::string> truths{};  ///< of logs that do not hold it: one for all of them, or one for each
  LogReadOptions reading{};
  double confidence = 0.95;
  double within = 0.1;       ///< margin of what is told as proved, between 1/(1 + this) and 1 + this
  bool sensitivity = false;  ///< judge without gross outliers too
  int threads = 0;           ///< 0: one for each processor; the bits do not depend on it
  const std::atomic<bool>* stop = nullptr;  ///< set: what was read until then is judged
  JudgeProgress progress{};                 ///< of the bytes of all files
};

/// Judges logs of one filter, files or folders of them, as `credence check` does.
///
/// Throws DataError for a file that cannot be read or a run that is there twice, std::invalid_argument for
/// options that do not fit the files, with what would be accepted, and std::runtime_error where it was
/// stopped before the first rows were judged.
JudgedFilter check_logs(std::span<const std::string> logs, const CheckOptions& options = {});

}  // namespace credence
