#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/logs/short_number.h"

namespace credence::internal {

/// What some tools write before text of UTF-8.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// Throws DataError for a file that begins as text of UTF-16 does.
void refuse_utf16(const std::filesystem::path& file, std::string_view beginning);

/// The lines of a text file one after another, in bounded memory, with LF or CR LF ends and without a byte
/// order mark.
///
/// Every error is a DataError that names the file and, where there is one, the line: no such file, not a
/// regular file, unreadable, text of UTF-16, a line above 16 MB, a last line without its end (a file cut in
/// the middle of a number would otherwise pass for a whole one).
class LineReader {
 public:
  /// So many characters behind each line may be read, too.
  static constexpr std::size_t kReadable = static_cast<std::size_t>(kReadBeyond);

  explicit LineReader(std::filesystem::path file);

  /// The next line without its end, valid until the next call; false at the end of the file.
  bool next(std::string_view& line);

  std::int64_t line_number() const { return line_number_; }  ///< of the last line, from 1
  std::int64_t bytes_read() const { return bytes_read_; }
  const std::filesystem::path& file() const { return file_; }

  /// Throws DataError at the last line.
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  bool fill();

  std::filesystem::path file_;
  std::ifstream in_;
  std::vector<char> buffer_;         // with kReadable characters behind what is filled
  std::size_t begin_ = 0, end_ = 0;  // what of the buffer is still to be given
  std::int64_t line_number_ = 0, bytes_read_ = 0;
};

}  // namespace credence::internal
