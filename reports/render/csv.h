#pragma once

#include <concepts>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "reports/render/atomic_file.h"

/// @file
/// Comma-separated values for other programs (RFC 4180: lines end with CR LF, text is quoted where it must
/// be).

namespace credence::internal {

/// One field. Doubles are written with the fewest digits that read back as the same bits; "nan", "inf",
/// "-inf".
struct CsvField {
  CsvField(double value);       // NOLINT: fields are written as literals
  CsvField(std::string words);  // NOLINT
  CsvField(const char* words);  // NOLINT
  template <std::integral Integer>
  CsvField(Integer value) : text(std::to_string(value)) {}  // NOLINT

  std::string text;
};

/// One record with its line end; fields with a comma, a quote or a line break are quoted.
std::string csv_record(std::span<const CsvField> fields);

/// Writes records to a file that appears, whole, at commit(). Throws OutputError when it cannot be written
/// and std::invalid_argument for a record whose number of fields is not that of the header.
class CsvWriter {
 public:
  CsvWriter(const std::filesystem::path& target, std::vector<std::string> columns);

  void add(std::span<const CsvField> fields);
  void add(std::initializer_list<CsvField> fields);
  void commit();

 private:
  void flush();

  AtomicFile file_;
  std::size_t columns_;
  std::string pending_;
};

}  // namespace credence::internal
