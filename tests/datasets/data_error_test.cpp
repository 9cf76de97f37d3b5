#include "datasets/data_error.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>

#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

TEST(DataError, IsOneSentenceOfFilePlaceAndProblem) {
  const DataError line("dir/a.csv", "12", "no number");
  EXPECT_EQ(std::string(line.what()), "dir/a.csv:12: no number");
  EXPECT_EQ(line.file(), "dir/a.csv");
  EXPECT_EQ(line.place(), "12");
  const DataError whole("a.mat", "", "is empty");
  EXPECT_EQ(std::string(whole.what()), "a.mat: is empty") << "the whole file has no place";
  EXPECT_EQ(whole.place(), "");
}

/// What open_data says of a file that it refuses; "" where it opens it.
std::string refusal(const std::filesystem::path& file) {
  try {
    open_data(file);
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

TEST(DataError, APipeIsNotWaitedFor) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "pipe.csv";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(refusal(pipe), pipe.string() + ": is a pipe; credence check - reads one, from standard input");
}

TEST(DataError, ALoopOfLinksIsNotSaidToBeMissing) {
  const TemporaryFolder folder;
  const std::filesystem::path loop = folder / "loop.csv";
  std::filesystem::create_symlink("loop.csv", loop);
  EXPECT_EQ(refusal(loop), loop.string() + ": cannot be read (Too many levels of symbolic links)");
}

}  // namespace
}  // namespace credence::internal
