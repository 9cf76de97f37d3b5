#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/nan.h"
#include "datasets/logs/log_read_options.h"
#include "datasets/logs/log_sink.h"
#include "datasets/logs/trajectory_errors.h"
#include "datasets/logs/truth_files.h"

/// @file
/// The formats of logs that are read: a format is a pair of files and a line in the list of
/// log_formats.cpp.

namespace credence::internal {

/// What a format is told: the user's options, and what is found once for all files.
struct LogReading : LogReadOptions {
  TruthFiles truth{};  ///< --truth
  /// Of all files together, where it is to be found so and there are several.
  std::shared_ptr<const TimeOffset> common_offset{};
};

/// One series of messages, or one array, in a log.
struct LogTopic {
  std::string name;
  std::string type;
  std::int64_t count = 0;
  double rate_hz = kNaN;  ///< messages but one, over the time between first and last; NaN: not known
  /// What it can be: "estimate", "truth", "innovations", … "" where nothing here can use it.
  std::string use;
  bool covariance = false;
};

/// What is in a log, without judging it.
struct LogContents {
  std::vector<LogTopic> topics;
  std::string remark;  ///< a sentence, or nothing
};

/// (count − 1) / (last − first), times in seconds; NaN for fewer than two.
double message_rate(std::int64_t count, double first_s, double last_s);

/// A format of logs.
struct LogFormat {
  std::string_view name;        ///< of --input
  std::string_view title;       ///< for reports
  std::string_view extensions;  ///< of its files, each with its dot, separated by blanks
  bool takes_truth = false;     ///< uses LogReading::truth
  bool has_poses = false;       ///< uses all of LogReadOptions::matching, and a chart
  bool has_topics = false;      ///< uses LogReadOptions::topic
  bool holds_truth = false;     ///< uses LogReadOptions::truth_topic
  bool has_instances = false;   ///< uses LogReadOptions::instance
  /// Whether a file that begins so can be of this format.
  std::function<bool(std::string_view beginning, const std::filesystem::path& file)> recognises;
  /// What is in a file. Throws DataError.
  std::function<LogContents(const std::filesystem::path& file)> list;
  /// Of has_poses: what the time offset of several files is found from. Throws as `read`.
  std::function<PosesWithTruth(const std::filesystem::path& file, const LogReading& options)> poses = {};
  /// Reads a file, in one pass or two. Throws DataError, and std::invalid_argument for options that do not
  /// fit the file, with what would be accepted.
  std::function<void(const std::filesystem::path& file, const LogReading& options, LogSink& sink)> read;
};

/// All of them, the most easily told apart first.
std::span<const LogFormat> log_formats();

/// The format with this name. Throws std::invalid_argument that names all.
const LogFormat& log_format_named(std::string_view name);

/// The format of a file, from how it begins, or the one with this name. Throws DataError that says what is
/// accepted, and as log_format_named.
const LogFormat& log_format_of(const std::filesystem::path& file, std::string_view name = "auto");

/// The files that arguments mean: a file itself, of a folder those with the extension of a format, in
/// capitals or not (in the order of their names). Throws DataError for a folder without any, and for a file
/// that is there twice.
std::vector<std::filesystem::path> log_files(std::span<const std::string> arguments);

/// What the folders among them hold besides, in a sentence; empty: nothing.
std::string files_left_out(std::span<const std::string> arguments);

}  // namespace credence::internal
