#include "datasets/logs/log_name.h"

#include <filesystem>

namespace credence::internal {

std::string log_name(const std::string& path) {
  const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).stem().string();
}

}  // namespace credence::internal
