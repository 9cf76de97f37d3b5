#include "datasets/logs/line_reader.h"

#include <gmock/gmock.h>

#include "datasets/data_error.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> lines_of(const std::string& text) {
  const TemporaryFolder folder;
  LineReader reader(folder.write("lines.txt", text));
  std::vector<std::string> lines;
  for (std::string_view line; reader.next(line);) {
    lines.emplace_back(line);
    EXPECT_EQ(reader.line_number(), std::ssize(lines));
  }
  EXPECT_EQ(reader.bytes_read(), std::ssize(text));
  std::string_view behind = "kept";
  EXPECT_FALSE(reader.next(behind)) << "the end stays the end";
  return lines;
}

void expect_line_error(const std::string& text, const std::string& problem) {
  EXPECT_THAT([&] { lines_of(text); }, ::testing::ThrowsMessage<DataError>(HasSubstr(problem)));
}

TEST(LineReader, lines_end_with_lf_or_cr_lf) {
  EXPECT_THAT(lines_of("one\ntwo\r\n\n\r\n\rthree\r\r\n"), ElementsAre("one", "two", "", "", "\rthree\r"));
  EXPECT_THAT(lines_of(""), IsEmpty());
  EXPECT_THAT(lines_of(std::string("a\0b\n", 4)), ElementsAre(std::string("a\0b", 3)));
}

TEST(LineReader, a_byte_order_mark_is_no_part_of_the_first_line) {
  EXPECT_THAT(lines_of("\xEF\xBB\xBFone\ntwo\n"), ElementsAre("one", "two"));
  EXPECT_THAT(lines_of("\xEF\xBB\xBF"), IsEmpty());
  EXPECT_THAT(lines_of("one\n\xEF\xBB\xBFtwo\n"), ElementsAre("one", "\xEF\xBB\xBFtwo"));
}

TEST(LineReader, a_last_line_without_its_end_is_an_error_that_names_it) {
  expect_line_error("one\ntwo", "lines.txt:2: the last line has no end: cut off?");
  expect_line_error("one", "lines.txt:1: the last line has no end");
  expect_line_error("one\r", "lines.txt:1: the last line has no end");
}

// 65,536 bytes are read at first; lines end before, at and behind that place.
TEST(LineReader, lines_across_the_end_of_the_buffer_are_whole) {
  for (const std::size_t first : {65534U, 65535U, 65536U, 65537U, 131071U, 131072U, 200000U}) {
    const std::string one(first, 'a'), two(first / 2, 'b'), three(3 * first, 'c');
    EXPECT_THAT(lines_of(one + "\r\n" + two + "\n\n" + three + "\nend\n"),
                ElementsAre(one, two, "", three, "end"));
  }
}

TEST(LineReader, a_line_above_16_mb_is_an_error_before_it_is_held) {
  const std::string longest((std::size_t{1} << 24) - 1, 'x');
  EXPECT_EQ(lines_of("first\n" + longest + "\n").at(1).size(), longest.size());
  expect_line_error("first\n" + longest + "xx\n", "lines.txt:2: the line is longer than 16 MB");
}

TEST(LineReader, text_of_utf_16_is_named) {
  expect_line_error(std::string("\xff\xfe"
                                "a\0\n\0",
                                6),
                    "lines.txt: is text of UTF-16; save it as UTF-8");
  EXPECT_THAT(lines_of("\xff\n"), ElementsAre("\xff"));
}

TEST(LineReader, what_is_no_file_is_named) {
  const TemporaryFolder folder;
  EXPECT_THAT([&] { LineReader(folder / "absent"); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("absent: there is no such file")));
  EXPECT_THAT([&] { LineReader(folder.path()); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("is not a regular file")));
}

TEST(LineReader, a_problem_is_told_at_the_last_line) {
  const TemporaryFolder folder;
  LineReader reader(folder.write("lines.txt", "a\nb\nc\n"));
  std::string_view line;
  reader.next(line);
  reader.next(line);
  EXPECT_THAT([&] { reader.fail("odd"); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("lines.txt:2: odd")));
}

}  // namespace
}  // namespace credence::internal
