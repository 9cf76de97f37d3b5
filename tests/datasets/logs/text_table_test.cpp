#include "datasets/logs/text_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "datasets/data_error.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

std::string error_of(const std::filesystem::path& file, Index columns) {
  try {
    read_text_table(file, columns);
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

TEST(TextTable, ReadsNumbersBetweenBlanksAndComments) {
  const TemporaryFolder folder;
  const TextTable table =
      read_text_table(folder.write("t.dat", "# head\n  1 \t -2.5e1 \n\n# more\n3\t4\r\n"), 2);
  EXPECT_EQ(table.values, (Matrix(2, 2) << 1, -25, 3, 4).finished());
  EXPECT_EQ(table.lines, (std::vector<int>{2, 5}));
}

TEST(TextTable, NamesTheLine) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& text) { return error_of(folder.write("t.dat", text), 2); };
  EXPECT_THAT(error("#\n1 2\n3\n"), HasSubstr("t.dat:3: 1 numbers where 2"));
  EXPECT_THAT(error("1 2\n3 4 5\n"), HasSubstr("t.dat:2: 3 numbers where 2"));
  EXPECT_THAT(error("1 2\n3 4x\n"), HasSubstr("t.dat:2: '4x' is not a finite number"));
  EXPECT_THAT(error("1 nan\n"), HasSubstr("t.dat:1: 'nan' is not a finite number"));
  EXPECT_THAT(error("1 1e999\n"), HasSubstr("t.dat:1: '1e999' is not a finite number"));
  EXPECT_THAT(error(std::string("1 \0\x01\n", 5)), HasSubstr("t.dat:1: '?"
                                                             "?' is not a finite number"));
  EXPECT_THAT(error("1 2\n3 4"), HasSubstr("t.dat:2: the last line has no end"));
  EXPECT_THAT(error("# only a comment\n"), HasSubstr("t.dat: holds no rows"));
  EXPECT_THAT(error(""), HasSubstr("holds no rows"));
  EXPECT_THAT(error_of(folder.path() / "absent.dat", 2), HasSubstr("absent.dat: there is no such file"));
  EXPECT_THAT(error_of(folder.path(), 2), HasSubstr("not a regular file"));
}

TEST(TextTable, EveryCutWithinALineIsAnError) {
  const TemporaryFolder folder;
  const std::string text = "# t v\n1.5 0.25\n2.5 -0.125\n";
  for (std::size_t size = 0; size < text.size(); ++size) {
    const bool at_end_of_line = size > 6 && text[size - 1] == '\n';
    const std::string error = error_of(folder.write("t.dat", text.substr(0, size)), 2);
    EXPECT_EQ(error == "no error", at_end_of_line) << "cut to " << size << " bytes: " << error;
  }
}

TEST(TextTable, FlippedBytesAreAnErrorOrNumbers) {
  const TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 20; ++i) text += std::to_string(i) + ".5 \t -0." + std::to_string(i * i) + " \n";
  std::mt19937 random(5);
  for (int trial = 0; trial < 1000; ++trial) {
    std::string broken = text;
    for (auto flips = 1 + random() % 3; flips > 0; --flips)
      broken[random() % text.size()] = static_cast<char>(random());
    const auto file = folder.write("t.dat", broken);
    try {
      EXPECT_TRUE(read_text_table(file, 2).values.allFinite());
    } catch (const DataError& error) {
      EXPECT_EQ(error.file(), file);
    }
  }
}

}  // namespace
}  // namespace credence::internal
