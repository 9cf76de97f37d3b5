#include "app/binary_frames.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "core/nan.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

// IEEE 754: 1 is 0x3FF0000000000000, −2 is 0xC000000000000000.
TEST(BinaryFrames, ANumberIsEightBytesTheLeastFirst) {
  const double row[] = {1.0, -2.0};
  EXPECT_EQ(frame_of(row), std::string("\0\0\0\0\0\0\xF0\x3F\0\0\0\0\0\0\0\xC0", 16));
  EXPECT_EQ(frame_of({}), "");
}

TEST(BinaryFrames, WholeNumbersAreThoseThatStandFirstAndAreSome) {
  const double row[] = {3.0, 1e6, 2.0, 0.1, kNaN};
  EXPECT_EQ(csv_row(row, 2), "3,1000000,2,0.1,");
  const double none[] = {2.5, 1e300, kNaN};
  EXPECT_EQ(csv_row(none, 3), "2.5,1e+300,") << "no integer is made of what is none";
}

class FramesToCsv : public ::testing::Test {
 protected:
  std::string csv_of(const std::string& stream) const {
    frames_to_csv(folder_.write("frames", stream), folder_ / "csv");
    return folder_.read("csv");
  }
  TemporaryFolder folder_;
};

TEST_F(FramesToCsv, EveryNumberReadsBackAsTheSameBits) {
  const double row[] = {0.0, 7.0, 1.0 / 3.0, -5e-324, std::numeric_limits<double>::max(), kNaN};
  const std::string csv = csv_of("# credence frames 1\n# a comment\nrun,step,a,b,c,d\n" + frame_of(row));
  const std::string head = "run,step,a,b,c,d\n0,7,";
  ASSERT_TRUE(csv.starts_with(head)) << csv;
  const char* at = csv.c_str() + head.size();
  for (std::size_t i = 2; i < 5; ++i) {
    char* end = nullptr;
    EXPECT_EQ(std::strtod(at, &end), row[i]) << i;
    at = end + 1;
  }
  EXPECT_TRUE(csv.ends_with(",\n"));
}

TEST_F(FramesToCsv, WithoutRowsThereAreTheNames) {
  EXPECT_EQ(csv_of("# credence frames 1\nstep,x\n"), "step,x\n");
}

TEST_F(FramesToCsv, WhatBreaksOffIsNamedWithItsPlace) {
  const double row[] = {1.0, 2.0};
  const auto refused = [&](const std::string& stream) {
    try {
      return csv_of(stream);
    } catch (const std::runtime_error& error) {
      return "refused: " + std::string(error.what());
    }
  };
  EXPECT_THAT(refused("# credence frames 1\nstep,x\n" + frame_of(row) + "abc"),
              HasSubstr("refused: frames: row 2 breaks off after 3 of 16 bytes"));
  for (const char* headless : {"", "# credence frames 1\n", "# credence frames 1\nstep,x"}) {
    EXPECT_THAT(refused(headless), HasSubstr("refused: frames: the stream has no line with names"))
        << headless;
  }
}

TEST_F(FramesToCsv, AStreamIsKnownByItsFirstLine) {
  EXPECT_TRUE(holds_frames(folder_.write("a", "# credence frames 1\nstep,x\n")));
  EXPECT_FALSE(holds_frames(folder_.write("b", "# credence frames 2\nstep,x\n")));
  EXPECT_FALSE(holds_frames(folder_.write("c", "step,x\n1,2\n")));
  EXPECT_FALSE(holds_frames(folder_.write("d", "")));
  EXPECT_FALSE(holds_frames(folder_ / "none"));
}

}  // namespace
}  // namespace credence::internal
