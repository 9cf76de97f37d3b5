#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/append_item.h"
#include "datasets/data_error.h"
#include "datasets/logs/arrays/mat_arrays.h"
#include "datasets/logs/arrays/npz.h"
#include "datasets/logs/autopilot/dataflash_innovations.h"
#include "datasets/logs/autopilot/ulog_innovations.h"
#include "datasets/logs/filter_log.h"
#include "datasets/logs/line_reader.h"
#include "datasets/logs/log_format.h"
#include "datasets/logs/number_field.h"
#include "datasets/logs/ros/ros_log.h"
#include "datasets/logs/rtklib.h"
#include "datasets/logs/trajectory_log.h"

namespace credence::internal {
namespace {

constexpr std::size_t kBeginning = 4096;
constexpr std::size_t kPoseFields = 8;  ///< fields of a pose at a time

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

/// Formats near to one that is read, with what would make it one; empty of all others.
std::string_view near_miss(std::string_view beginning) {
  if (beginning.starts_with("\x1f\x8b")) return "it is compressed by gzip: zcat FILE | credence check -";
  if (beginning.starts_with("\x93NUMPY"))
    return "it is a single array of NumPy: np.savez('runs.npz', error=…, P=…) names several in one file "
           "(docs/logs.md)";
  while (beginning.starts_with('#') && beginning.find('\n') != std::string_view::npos)
    beginning.remove_prefix(beginning.find('\n') + 1);
  const std::vector<std::string_view> numbers =
      words_between(" \t", beginning.substr(0, beginning.find_first_of("\r\n")));
  if (numbers.empty() || !parse_finite(numbers.front())) return "";
  const std::size_t fields = numbers.size();
  constexpr std::size_t kTum = 29, kAllOfP = 44;
  if (fields == kAllOfP || (fields > kPoseFields && fields < kTum)) {
    return fields == kAllOfP
               ? "of a TUM trajectory the covariance is its upper triangle by rows, 21 numbers; all 36 are "
                 "taken of a CSV of poses (docs/formats.md)"
               : "a TUM trajectory has 29 fields: t x y z qx qy qz qw and the upper triangle of the 6×6 "
                 "covariance by rows";
  }
  return "";
}

bool has_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
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
  if (beginning.starts_with(kByteOrderMark)) beginning.erase(0, kByteOrderMark.size());
  refuse_hdf5(file, beginning);
  for (const LogFormat& format : log_formats()) {
    if (format.recognises(beginning, file)) return format;
  }
  const std::string_view near = near_miss(beginning);
  throw DataError(file, "",
                  fmt::format("is of no known format; {}accepted are {}",
                              near.empty() ? "" : fmt::format("{}; ", near), names_of_formats()));
}

namespace {

/// What a folder holds that is no log by its name, hidden files left out: "r04.txt, sub/ and 2 more".
std::string others_in(const std::filesystem::path& folder) {
  constexpr std::size_t kTold = 3;
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool of_bag = name == "metadata.yaml";  // beside a ROS 2 bag
    if (of_bag || name.starts_with('.') || (!entry.is_directory() && has_extension(entry.path()))) continue;
    names.push_back(name + (entry.is_directory() ? "/" : ""));
  }
  std::ranges::sort(names);
  return first_items(names, kTold);
}

}  // namespace

std::string files_left_out(std::span<const std::string> arguments) {
  std::string text;
  for (const std::string& argument : arguments) {
    if (!std::filesystem::is_directory(argument)) continue;
    const std::string others = others_in(argument);
    if (!others.empty()) append_item(text, fmt::format("of {} {}", argument, others), "; ");
  }
  if (!text.empty()) text = fmt::format("Left out, as their names do not end as those of logs do: {}.", text);
  return text;
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
      if (!entry.is_directory() && has_extension(entry.path())) inside.push_back(entry.path());
    }
    if (inside.empty()) {
      std::string extensions;
      for (const LogFormat& format : log_formats()) {
        if (!format.extensions.empty()) extensions += fmt::format(" {}", format.extensions);
      }
      const std::string others = others_in(argument);
      throw DataError(argument, "",
                      fmt::format("the folder holds no logs: no file with one of{}{}", extensions,
                                  others.empty() ? "" : "; it holds " + others));
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
