#include "reports/render/csv.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace credence::internal {
namespace {

// Records are handed to the system in blocks of about this many bytes.
constexpr std::size_t kBlock = 1 << 16;

}  // namespace

CsvField::CsvField(double value) : text(fmt::format("{}", value)) {}
CsvField::CsvField(std::string words) : text(std::move(words)) {}
CsvField::CsvField(const char* words) : text(words) {}

std::string csv_record(std::span<const CsvField> fields) {
  std::string record;
  for (const CsvField& field : fields) {
    if (&field != fields.data()) record += ',';
    if (field.text.find_first_of(",\"\r\n") == std::string::npos) {
      record += field.text;
      continue;
    }
    record += '"';
    for (const char c : field.text) {
      if (c == '"') record += '"';
      record += c;
    }
    record += '"';
  }
  return record + "\r\n";
}

CsvWriter::CsvWriter(const std::filesystem::path& target, std::vector<std::string> columns)
    : file_(target), columns_(columns.size()) {
  const std::vector<CsvField> header(columns.begin(), columns.end());
  add(header);
}

void CsvWriter::add(std::span<const CsvField> fields) {
  if (fields.size() != columns_) {
    throw std::invalid_argument(
        fmt::format("CSV record of {} fields for {} columns", fields.size(), columns_));
  }
  pending_ += csv_record(fields);
  if (pending_.size() >= kBlock) flush();
}

void CsvWriter::add(std::initializer_list<CsvField> fields) {
  add(std::span<const CsvField>(fields.begin(), fields.size()));
}

void CsvWriter::commit() {
  flush();
  file_.commit();
}

void CsvWriter::flush() {
  file_.write(pending_);
  pending_.clear();
}

}  // namespace credence::internal
