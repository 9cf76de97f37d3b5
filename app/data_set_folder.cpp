#include "app/data_set_folder.h"

#include <fmt/format.h>

#include <cstdlib>
#include <stdexcept>

namespace credence::internal {

std::filesystem::path data_set_folder(const std::string& directory, const char* name) {
  const std::filesystem::path folder = directory;
  return std::filesystem::is_directory(folder / name) ? folder / name : folder;
}

std::vector<std::filesystem::path> data_set_folders(const std::vector<std::string>& directories,
                                                    const char* name) {
  const char* const named = std::getenv("CREDENCE_DATA");
  if (directories.empty() && named != nullptr) return {data_set_folder(named, name)};
  if (directories.empty()) {
    throw std::invalid_argument(
        "--data: name the folder with the data set, or set CREDENCE_DATA (docs/datasets.md)");
  }
  std::vector<std::filesystem::path> folders;
  folders.reserve(directories.size());
  for (const std::string& directory : directories) folders.push_back(data_set_folder(directory, name));
  return folders;
}

std::filesystem::path carpark_folder(const std::vector<std::string>& directories,
                                     const std::vector<int>& robots) {
  if (!robots.empty())
    throw std::invalid_argument("--robot: only of mrclam; a single car drove in the car park");
  const std::vector<std::filesystem::path> folders = data_set_folders(directories, "carpark");
  if (folders.size() > 1) {
    throw std::invalid_argument("--data: the car park was driven once, name one folder");
  }
  return folders.front();
}

ReplaySettings with_overrides(ReplaySettings settings, const std::vector<std::string>& overrides) {
  for (const std::string& text : overrides) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw std::invalid_argument(fmt::format("--set {}: accepted is section.key=value", text));
    }
    set_replay_setting(settings, text.substr(0, equals), text.substr(equals + 1));
  }
  check_replay_settings(settings);
  return settings;
}

}  // namespace credence::internal
