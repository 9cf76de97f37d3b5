#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "datasets/data_error.h"
#include "datasets/logs/log_format.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/temporary_folder.h"

namespace credence::internal::testing {

/// Reads a file that may be anything: true if it could be read, false for an error that names the file, and a
/// failed test for all else.
inline bool reads(const LogFormat& format, const std::filesystem::path& file, const LogReading& options,
                  const std::string& what) {
  RecordedSink sink;
  try {
    format.read(file, options, sink);
    format.list(file);
    return true;
  } catch (const DataError& error) {
    EXPECT_EQ(error.file(), file) << what;
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(file.filename().string()), std::string::npos) << error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << what << ": " << error.what();
  }
  return false;
}

/// Reads a file cut off at every byte, and with every byte changed, in one of three ways: whatever comes of
/// it, it is no crash. Returns at how many bytes a cut was not noticed.
inline std::size_t unnoticed_cuts(const LogFormat& format, const std::string& whole,
                                  const LogReading& options) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("hostile.log", whole);
  EXPECT_TRUE(reads(format, file, options, "whole"));
  std::size_t unnoticed = 0;
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    folder.write("hostile.log", whole.substr(0, cut));
    unnoticed += reads(format, file, options, "cut at " + std::to_string(cut)) ? 1 : 0;
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    constexpr int kFlips[] = {0x01, 0x80, 0xff};
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ kFlips[at % 3]);
    folder.write("hostile.log", flipped);
    reads(format, file, options, "flipped at " + std::to_string(at));
  }
  return unnoticed;
}

}  // namespace credence::internal::testing
