#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <stdexcept>

#include "core/append_item.h"
#include "datasets/data_error.h"
#include "datasets/logs/arrays/mat_arrays.h"
#include "datasets/logs/arrays/npz.h"
#include "datasets/logs/autopilot/dataflash_innovations.h"
#include "datasets/logs/autopilot/ulog_innovations.h"
#include "datasets/logs/filter_log.h"
#include "datasets/logs/line_reader.h"
#include "datasets/logs/log_format.h"
#include "datasets/logs/ros/ros_log.h"
#include "datasets/logs/rtklib.h"
#include "datasets/logs/trajectory_log.h"

namespace credence::internal {
namespace {

constexpr std::size_t kBeginning = 4096;

std::string names_of_formats() {
  std::string names;
  for (const LogFormat& format : log_formats()) {
    append_item(names, fmt::format("{} ({})", format.name, format.title));
  }
  return names;
}

/// HDF5, whose arrays one line of Python writes as the .npz that is read; MATLAB's, with a header of its own,
/// are refused by their reader.
void refuse_hdf5(const std::filesystem::path& file, std::string_view beginning) {
  if (!beginning.starts_with("\x89HDF\r\n\x1a\n")) return;
  throw DataError(
      file, "",
      "is HDF5, which is not read; with its arrays at the top, called as in docs/logs.md: python3 -c "
      "\"import h5py, numpy as np; "
      "np.savez('runs.npz', **{k: v[()] for k, v in h5py.File('FILE').items()})\"");
}

bool has_extension(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  return !extension.empty() && std::ranges::any_of(log_formats(), [&](const LogFormat& format) {
    return fmt::format(" {} ", format.extensions).find(" " + extension + " ") != std::string::npos;
  });
}

}  // namespace

std::span<const LogFormat> log_formats() {
  static const LogFormat formats[] = {
      mcap_format(),  ros2_sqlite_format(), ros1_bag_format(), ulog_format(),     dataflash_format(),
      npz_format(),   mat_format(),         rtklib_format(),   openvins_format(), tum_format(),
      cnspy_format(), pose_csv_format(),    own_format(),
  };
  return formats;
}

const LogFormat& log_format_named(std::string_view name) {
  const auto found = std::ranges::find(log_formats(), name, &LogFormat::name);
  if (found == log_formats().end()) {
    throw std::invalid_argument(fmt::format("--input {}: accepted are auto, {}", name, names_of_formats()));
  }
  return *found;
}

const LogFormat& log_format_of(const std::filesystem::path& file, std::string_view name) {
  if (name != "auto") return log_format_named(name);
  std::ifstream in = open_data(file);
  std::string beginning(kBeginning, '\0');
  in.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  beginning.resize(static_cast<std::size_t>(in.gcount()));
  if (beginning.empty()) throw DataError(file, "", "is empty, or cannot be read");
  refuse_utf16(file, beginning);
  refuse_hdf5(file, beginning);
  for (const LogFormat& format : log_formats()) {
    if (format.recognises(beginning, file)) return format;
  }
  throw DataError(file, "", fmt::format("is of no known format; accepted are {}", names_of_formats()));
}

std::vector<std::filesystem::path> log_files(std::span<const std::string> arguments) {
  std::vector<std::filesystem::path> files;
  for (const std::string& argument : arguments) {
    if (argument.empty()) throw std::invalid_argument("the name of a log is empty");
    if (!std::filesystem::is_directory(argument)) {
      files.emplace_back(argument);
      continue;
    }
    std::vector<std::filesystem::path> inside;
    for (const auto& entry : std::filesystem::directory_iterator(argument)) {
      if (has_extension(entry.path())) inside.push_back(entry.path());
    }
    if (inside.empty()) {
      std::string extensions;
      for (const LogFormat& format : log_formats()) {
        if (!format.extensions.empty()) extensions += fmt::format(" {}", format.extensions);
      }
      throw DataError(argument, "",
                      fmt::format("the folder holds no logs: no file with one of{}", extensions));
    }
    std::ranges::sort(inside);
    files.insert(files.end(), inside.begin(), inside.end());
  }
  std::set<std::filesystem::path> seen;
  for (const std::filesystem::path& file : files) {
    std::error_code error;
    const auto one = std::filesystem::canonical(file, error);
    if (!error && !seen.insert(one).second) {
      throw DataError(file, "", "is named twice: its runs would be counted twice");
    }
  }
  return files;
}

double message_rate(std::int64_t count, double first_s, double last_s) {
  return count > 1 && last_s > first_s ? static_cast<double>(count - 1) / (last_s - first_s) : kNaN;
}

}  // namespace credence::internal
