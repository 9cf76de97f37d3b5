#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/replay/replay_settings.h"

namespace credence::internal {

/// Where the files of a data set are: in DIR/`name` if there is such a folder, else in DIR itself.
std::filesystem::path data_set_folder(const std::string& directory, const char* name);

/// The same of every --data, or without any of CREDENCE_DATA. Throws std::invalid_argument for none.
std::vector<std::filesystem::path> data_set_folders(const std::vector<std::string>& directories,
                                                    const char* name);

/// That of the car park, of which there is one. Throws std::invalid_argument where robots are named beside
/// it.
std::filesystem::path carpark_folder(const std::vector<std::string>& directories,
                                     const std::vector<int>& robots = {});

/// Settings of a replay with those of --set. Throws std::invalid_argument that names the key.
ReplaySettings with_overrides(ReplaySettings settings, const std::vector<std::string>& overrides);

}  // namespace credence::internal
