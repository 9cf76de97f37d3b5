#include "datasets/data_error.h"

namespace credence {

using namespace internal;

DataError::DataError(const std::filesystem::path& file, const std::string& place, const std::string& problem)
    : std::runtime_error(file.string() + (place.empty() ? "" : ":" + place) + ": " + problem),
      file_(file),
      place_(place) {}

}  // namespace credence
