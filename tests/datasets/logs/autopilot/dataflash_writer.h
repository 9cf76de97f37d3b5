#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "tests/datasets/logs/byte_writer.h"

namespace credence::internal::testing {

inline std::string padded(std::string text, std::size_t size) {
  text.resize(size, '\0');
  return text;
}

/// Writes a log as ArduPilot's logger does.
class DataflashWriter {
 public:
  DataflashWriter() {
    describe(0x80, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    describe(1, 3 + 8 + 16 + 4, "PARM", "QNf", "TimeUS,Name,Value");
    describe(2, 3 + 9 + 22, "XKF3", "QBcccccchhhcc", "TimeUS,C,IVN,IVE,IVD,IPN,IPE,IPD,IMX,IMY,IMZ,IYAW,IVT");
    describe(3, 3 + 9 + 10, "XKF4", "QBccccc", "TimeUS,C,SV,SP,SH,SM,SVT");
  }

  void describe(std::uint8_t type, std::size_t length, const std::string& name, const std::string& letters,
                const std::string& names) {
    message(0x80, ByteWriter()
                      .add(type)
                      .add(static_cast<std::uint8_t>(length))
                      .text(padded(name, 4) + padded(letters, 16) + padded(names, 64))
                      .bytes());
  }
  void message(std::uint8_t type, const std::string& body) {
    file_.add<std::uint8_t>(0xa3).add<std::uint8_t>(0x95).add(type).text(body);
  }
  void parameter(const std::string& name, float value) {
    message(1, ByteWriter().add<std::uint64_t>(0).text(padded(name, 16)).add(value).bytes());
  }
  /// Innovations of velocity (3), position (2), height and airspeed; the rest is 0.
  void innovations(std::uint64_t time, std::uint8_t core, const std::array<double, 7>& nu) {
    ByteWriter body;
    body.add(time).add(core);
    for (int i = 0; i < 6; ++i) hundredths(body, nu[static_cast<std::size_t>(i)]);
    for (int i = 0; i < 4; ++i) body.add<std::int16_t>(0);
    hundredths(body, nu[6]);
    message(2, body.bytes());
  }
  /// Roots of the test ratios of velocity, position, height, magnetometer and airspeed.
  void ratios(std::uint64_t time, std::uint8_t core, const std::array<double, 5>& roots) {
    ByteWriter body;
    body.add(time).add(core);
    for (const double root : roots) hundredths(body, root);
    message(3, body.bytes());
  }
  const std::string& bytes() const { return file_.bytes(); }

 private:
  static void hundredths(ByteWriter& body, double value) {
    body.add(static_cast<std::int16_t>(std::lround(100.0 * value)));
  }
  ByteWriter file_;
};

}  // namespace credence::internal::testing
