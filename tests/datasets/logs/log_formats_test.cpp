#include <fmt/format.h>
#include <gmock/gmock.h>

#include <gtest/gtest.h>
#include <cmath>
#include <set>

#include "datasets/data_error.h"
#include "datasets/logs/log_format.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

TEST(LogFormats, AFileIsKnownByHowItBegins) {
  const TemporaryFolder folder;
  const std::string pose = "1 0 0 0 0 0 0 1", twelve = " 1 0 0 1 0 1 1 0 0 1 0 1";
  std::string tum = pose;
  for (int i = 0; i < 21; ++i) tum += " 1";
  const std::pair<std::string, std::string> cases[] = {
      {"mcap", std::string("\x89MCAP0\r\n", 8)},
      {"rosbag", "#ROSBAG V2.0\n"},
      {"db3", std::string("SQLite format 3\0", 16)},
      {"ulog", std::string("\x55\x4c\x6f\x67\x01\x12\x35\x01", 8)},
      {"mat", "MATLAB 5.0 MAT-file" + std::string(105, ' ') + std::string("\x00\x01IM", 4)},
      {"dataflash", "\xa3\x95\x80\x80\x59"},
      {"npz", "PK\x03\x04"},
      {"rtklib", "% program   : RTKLIB\n%  GPST  latitude(deg)\n"},
      {"openvins", "# comment\n" + pose + twelve + "\n"},
      {"tum", tum + "\n"},
      {"cnspy", "t,tx,ty,tz,qx,qy,qz,qw,pxx,pxy,pxz,pyy,pyz,pzz,qrr,qrp,qry,qpp,qpy,qyy\n"},
      {"credence", "innovation.1,S.1.1\n1,1\n"}};
  for (const auto& [name, bytes] : cases) {
    EXPECT_EQ(log_format_of(folder.write("log", bytes)).name, name);
  }
  EXPECT_EQ(log_format_of(folder.write("log", pose + "\n")).name,
            "tum");  // whose reader says what is missing
  EXPECT_THAT([&] { log_format_of(folder.write("log", "1 2 3\n")); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("is of no known format; accepted are mcap")));
  EXPECT_THAT([&] { log_format_of(folder.write("log", "")); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("is empty")));
  for (const std::string mark : {"\xff\xfe", "\xfe\xff"}) {
    EXPECT_THAT([&] { log_format_of(folder.write("log", mark + std::string("a\0\n\0", 4))); },
                ::testing::ThrowsMessage<DataError>(HasSubstr("is text of UTF-16; save it as UTF-8")));
  }
  EXPECT_THAT([&] { log_format_of(folder / "absent"); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("there is no such file")));
}

TEST(LogFormats, NamesAreDifferentAndFindTheirFormat) {
  std::set<std::string_view> names;
  for (const LogFormat& format : log_formats()) {
    EXPECT_TRUE(names.insert(format.name).second) << format.name;
    EXPECT_EQ(&log_format_named(format.name), &format);
  }
  EXPECT_THAT([] { log_format_named("excel"); }, ::testing::ThrowsMessage<std::invalid_argument>(
                                                     HasSubstr("accepted are auto, mcap (ROS 2 bag, MCAP)")));
}

TEST(LogFormats, AFolderIsItsLogsInTheOrderOfTheirNames) {
  const TemporaryFolder folder;
  for (const char* name : {"b.ulg", "a.csv", "notes.txt", "c.mcap"}) folder.write(name, "x");
  const std::vector<std::string> arguments = {folder.path().string()};
  const auto files = log_files(arguments);
  ASSERT_EQ(files.size(), 3U);
  EXPECT_EQ(files[0].filename(), "a.csv");
  EXPECT_EQ(files[2].filename(), "c.mcap");
}

TEST(LogFormats, WhatAFolderHoldsBesidesItsLogsIsTold) {
  const TemporaryFolder folder;
  for (const char* name : {"b.CSV", "a.csv", "c.csv.gz", ".hidden", "metadata.yaml"}) folder.write(name, "x");
  std::filesystem::create_directory(folder.path() / "sub.csv");
  const std::vector<std::string> arguments = {folder.path().string()};
  EXPECT_EQ(log_files(arguments).size(), 2U);
  EXPECT_EQ(files_left_out(arguments),
            fmt::format("Left out, as their names do not end as those of logs do: of {} c.csv.gz, sub.csv/.",
                        arguments[0]));
  EXPECT_EQ(files_left_out(std::vector<std::string>{(folder.path() / "a.csv").string()}), "");
  const TemporaryFolder other;
  for (const char* name : {"a.txt", "b.txt", "c.txt", "d.txt"}) other.write(name, "x");
  EXPECT_THAT([&] { log_files(std::vector<std::string>{other.path().string()}); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("; it holds a.txt, b.txt, c.txt and 1 more")));
}

TEST(LogFormats, NearMissesAreNamed) {
  const TemporaryFolder folder;
  std::string all = "0";
  for (int i = 1; i < 44; ++i) all += " 0";
  for (const auto& [content, said] :
       {std::pair<std::string, std::string>{"\x1f\x8b\x08", "zcat FILE | credence"},
        {"\x93NUMPY\x01", "np.savez"},
        {all, "the covariance is its upper triangle by rows"},
        {"0 1 2 3 0 0 0 1 1 1 1 1 1 1", "has 29 fields"}}) {
    const auto file = folder.write("near.bin", content);
    EXPECT_THAT([&] { log_format_of(file, "auto"); }, ::testing::ThrowsMessage<DataError>(HasSubstr(said)))
        << said;
  }
}

TEST(LogFormats, ProseIsNearNoFormat) {
  const TemporaryFolder folder;
  const auto file = folder.write("near.bin", "A text of ten words that are no numbers at all.");
  EXPECT_THAT([&] { log_format_of(file, "auto"); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("is of no known format; accepted are mcap")));
}

// The line that converts is in what is said.
TEST(LogFormats, Hdf5IsNamedWithItsConversion) {
  const TemporaryFolder folder;
  for (const char* name : {"a.h5", "a.csv", "a.npz"}) {
    const auto file = folder.write(name, std::string("\x89HDF\r\n\x1a\n") + std::string(100, '\0'));
    EXPECT_THAT([&] { log_format_of(file, "auto"); },
                ::testing::ThrowsMessage<DataError>(
                    ::testing::AllOf(::testing::HasSubstr("is HDF5"), ::testing::HasSubstr("np.savez"))))
        << name;
  }
}

TEST(LogFormats, ALogHasAName) {
  EXPECT_THAT([] { log_files(std::vector<std::string>{""}); },
              ::testing::ThrowsMessage<std::invalid_argument>("the name of a log is empty"));
}

TEST(LogContents, a_rate_is_of_the_intervals_and_not_of_the_messages) {
  EXPECT_EQ(message_rate(11, 5.0, 6.0), 10.0);
  EXPECT_EQ(message_rate(2, -1.0, 1.0), 0.5);
}

TEST(LogContents, without_an_interval_there_is_no_rate) {
  EXPECT_TRUE(std::isnan(message_rate(1, 0.0, 1.0)));
  EXPECT_TRUE(std::isnan(message_rate(0, 0.0, 0.0)));
  EXPECT_TRUE(std::isnan(message_rate(5, 2.0, 2.0)));
  EXPECT_TRUE(std::isnan(message_rate(5, 2.0, 1.0)));
  EXPECT_TRUE(std::isnan(message_rate(5, 0.0, kNaN)));
}

}  // namespace
}  // namespace credence::internal
