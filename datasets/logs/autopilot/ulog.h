#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/logs/bytes/binary_file.h"

/// @file
/// The container of PX4's flight logs, ULog: docs.px4.io, "ULog File Format", version 1.

namespace credence::internal {

/// One field of a message.
struct UlogField {
  std::string name;
  std::string type;          ///< "float", "uint64_t", …, or the name of another format
  std::uint64_t count = 1;   ///< of an array
  std::uint64_t offset = 0;  ///< in the message, bytes
  std::uint64_t size = 0;    ///< of one entry, bytes
};

/// A topic of which messages follow.
struct UlogTopic {
  std::string name;
  int instance = 0;
  std::vector<UlogField> fields;

  /// nullptr where there is none of this name.
  const UlogField* field(std::string_view wanted) const;
};

/// One entry of a field of a message as a number. A field that is no number or that the message does not
/// reach to is a DataError.
double ulog_number(ByteCursor message, const UlogField& field, std::uint64_t entry = 0);

/// When what a message speaks of was measured, s: its timestamp_sample, or where there is none, or 0, its
/// timestamp, when it was sent. Throws DataError for a topic without either.
double ulog_time_s(const UlogTopic& topic, const ByteCursor& message);

struct UlogVisitor {
  /// Topics are counted from 0 in the order in which they come.
  std::function<void(std::size_t topic, const UlogTopic&)> topic;
  std::function<void(std::size_t topic, const ByteCursor& message)> message;
  std::function<void(double seconds)> dropout = [](double) {};  ///< so long nothing could be written
  std::function<void(std::int64_t bytes)> advance = [](std::int64_t) {};
  std::function<void(std::string_view name, double value)> parameter{};  ///< with its first value
};

/// Whether a file that begins so is a ULog.
bool begins_as_ulog(std::string_view beginning);

/// Reads a file in one pass, in memory for one message. Throws DataError with the byte: another magic, a
/// version or flag that is not known, a message that ends beyond the file, data of a topic that nobody
/// announced.
void read_ulog(const std::filesystem::path& file, const UlogVisitor& visitor);

}  // namespace credence::internal
