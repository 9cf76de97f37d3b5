#include "datasets/data_error.h"

#include <gtest/gtest.h>

#include <string>

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

}  // namespace
}  // namespace credence::internal
