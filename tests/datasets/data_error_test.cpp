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

TEST(DataError, APipeIsNotWaitedFor) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "pipe.csv";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  try {
    open_data(pipe);
    FAIL();
  } catch (const DataError& error) {
    EXPECT_EQ(std::string(error.what()),
              pipe.string() + ": is a pipe; credence check - reads one, from standard input");
  }
}

TEST(DataError, ALoopOfLinksIsNotSaidToBeMissing) {
  const TemporaryFolder folder;
  const std::filesystem::path loop = folder / "loop.csv";
  std::filesystem::create_symlink("loop.csv", loop);
  try {
    open_data(loop);
    FAIL();
  } catch (const DataError& error) {
    EXPECT_EQ(std::string(error.what()),
              loop.string() + ": cannot be read (Too many levels of symbolic links)");
  }
}

}  // namespace
}  // namespace credence::internal
