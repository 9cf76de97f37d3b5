#pragma once

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace credence {

/// A data file that cannot be used: missing, truncated, corrupted, or saying something impossible.
///
/// what() is one sentence "FILE:PLACE: problem" (or "FILE: problem" when the whole file is meant). The place
/// is a line number of a text file, or "variable 'NAME'" of a MAT file.
class DataError : public std::runtime_error {
 public:
  DataError(const std::filesystem::path& file, const std::string& place, const std::string& problem);

  const std::filesystem::path& file() const { return file_; }
  const std::string& place() const { return place_; }

 private:
  std::filesystem::path file_;
  std::string place_;
};

}  // namespace credence

namespace credence::internal {

/// Opens a data file to read its bytes; DataError where it is missing, no regular file, or cannot be read.
std::ifstream open_data(const std::filesystem::path& file);

}  // namespace credence::internal
