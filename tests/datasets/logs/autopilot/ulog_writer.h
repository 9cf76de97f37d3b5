#pragma once

#include <cstdint>
#include <string>

#include "tests/datasets/logs/byte_writer.h"

namespace credence::internal::testing {

/// Writes a flight log as the specification says.
class UlogWriter {
 public:
  UlogWriter() {
    file_.text(std::string("\x55\x4c\x6f\x67\x01\x12\x35\x01", 8)).add<std::uint64_t>(1000);
    message('B', std::string(40, '\0'));
  }

  void message(char type, const std::string& body) {
    file_.add(static_cast<std::uint16_t>(body.size())).add(type).text(body);
  }
  void format(const std::string& text) { message('F', text); }
  void subscribe(std::uint16_t id, int instance, const std::string& name) {
    message('A', ByteWriter().add(static_cast<std::uint8_t>(instance)).add(id).text(name).bytes());
  }
  void data(std::uint16_t id, const std::string& body) {
    message('D', ByteWriter().add(id).text(body).bytes());
  }
  const std::string& bytes() const { return file_.bytes(); }

 private:
  ByteWriter file_;
};

}  // namespace credence::internal::testing
