#include "datasets/data_error.h"

namespace credence {

using namespace internal;

DataError::DataError(const std::filesystem::path& file, const std::string& place, const std::string& problem)
    : std::runtime_error(file.string() + (place.empty() ? "" : ":" + place) + ": " + problem),
      file_(file),
      place_(place) {}

}  // namespace credence

namespace credence::internal {

std::ifstream open_data(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    throw DataError(file, "", error ? "cannot be read (" + error.message() + ")" : "there is no such file");
  }
  if (std::filesystem::is_fifo(file, error)) {
    throw DataError(file, "", "is a pipe; credence check - reads one, from standard input");
  }
  if (!std::filesystem::is_regular_file(file, error)) throw DataError(file, "", "is not a regular file");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw DataError(file, "", "cannot be read");
  return in;
}

}  // namespace credence::internal
