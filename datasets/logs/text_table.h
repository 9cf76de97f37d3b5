#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// A text file of numbers in columns separated by blanks, with lines of comment that begin with '#'.
struct TextTable {
  std::filesystem::path file;
  Matrix values;           ///< one row for each line of numbers
  std::vector<int> lines;  ///< the line number of each row, from 1

  Index rows() const { return values.rows(); }

  /// Throws DataError that names the line of row `row`.
  [[noreturn]] void fail(Index row, const std::string& problem) const;
};

/// Reads a table whose every row holds exactly `columns` finite numbers.
///
/// Throws DataError with the line for anything else, for a file without rows, and for a last line without
/// its end (a file cut in the middle of a number would otherwise pass for a whole one).
TextTable read_text_table(const std::filesystem::path& file, Index columns);

}  // namespace credence::internal
