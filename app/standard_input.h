#pragma once

#include <filesystem>
#include <string>

namespace credence::internal {

/// What comes on standard input as a file, which standard input then is, for as long as this lives: formats
/// of logs are seen from how a file begins, and some are read twice. Binary frames become the CSV that they
/// stand for.
class StandardInputFile {
 public:
  /// Reads to the end, or until an interruption is caught (interrupt.h), after which the file is of no use;
  /// throws std::runtime_error where it cannot be kept.
  StandardInputFile();
  ~StandardInputFile();  ///< removes the file
  StandardInputFile(const StandardInputFile&) = delete;
  StandardInputFile& operator=(const StandardInputFile&) = delete;

  /// Where it is read, as often as one likes.
  static constexpr const char* kName = "/dev/stdin";

 private:
  std::filesystem::path path() const { return folder_ / "stdin"; }

  std::filesystem::path folder_;
};

/// All of a file that an argument names; throws std::invalid_argument with the complaint, and for one of more
/// than 256 MiB.
std::string text_of_file(const std::string& file, const std::string& complaint);

}  // namespace credence::internal
