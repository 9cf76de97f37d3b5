#pragma once

#include <filesystem>
#include <string>

namespace credence {

/// Where the files of a data set are: in DIR/`name` if there is such a folder, else in DIR itself.
std::filesystem::path data_set_folder(const std::string& directory, const char* name);

}  // namespace credence
