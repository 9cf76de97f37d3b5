#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/logs/bytes/binary_file.h"

/// @file
/// The container of ArduPilot's flight logs, DataFlash (.bin): messages 0xa3 0x95 TYPE BODY, whose bodies are
/// described by messages FMT of the log itself.

namespace credence::internal {

/// A kind of message.
struct DataflashTopic {
  struct Field {
    std::string name;
    char type = 'b';           ///< a letter of FMT
    std::uint64_t offset = 0;  ///< in the body, bytes
  };
  std::string name;           ///< "XKF3"
  std::uint64_t size = 0;     ///< of the body, bytes
  std::vector<Field> fields;  ///< those that the letters and names of FMT both describe

  /// nullptr where there is none of this name.
  const Field* field(std::string_view wanted) const;
};

/// A field as a number, in its unit: of the letters c, C, e and E hundredths, of L 1e-7. Throws DataError for
/// a text, or a body that does not reach to it.
double dataflash_number(ByteCursor body, const DataflashTopic::Field& field);

/// A field of letters, up to its first zero; "" for a number.
std::string dataflash_text(ByteCursor body, const DataflashTopic::Field& field);

struct DataflashVisitor {
  std::function<void(std::uint8_t type, const DataflashTopic&)> topic;  ///< one may be described again
  std::function<void(std::uint8_t type, const ByteCursor& body)> message;
  std::function<void(std::int64_t bytes)> advance = [](std::int64_t) {};
};

/// Whether a file that begins so is a DataFlash log.
bool begins_as_dataflash(std::string_view beginning);

/// Reads a file in one pass, in memory for one message. Throws DataError with the byte: no message where one
/// should begin, a kind that no FMT described, a message that ends beyond the file, a FMT whose letters do
/// not fill its length.
void read_dataflash(const std::filesystem::path& file, const DataflashVisitor& visitor);

}  // namespace credence::internal
