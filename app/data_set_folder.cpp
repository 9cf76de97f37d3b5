#include "app/data_set_folder.h"

namespace credence {

std::filesystem::path data_set_folder(const std::string& directory, const char* name) {
  const std::filesystem::path folder = directory;
  return std::filesystem::is_directory(folder / name) ? folder / name : folder;
}

}  // namespace credence
