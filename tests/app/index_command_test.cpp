#include <gmock/gmock.h>

#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

class IndexCommand : public CommandTest {};

TEST_F(IndexCommand, CountsTheReportsOfAFolderAndBelow) {
  std::filesystem::create_directory(folder_ / "out");
  EXPECT_EQ(run({"index", "out"}).out, "0 reports: out/reports.html\n");
  const auto study = [&](const std::string& out) {
    ASSERT_EQ(run({"run", "figure1_two_landmarks", "--runs", "64", "--quiet", "--out", out}).code, 0);
  };
  study("out/one");
  EXPECT_EQ(run({"index", "out"}).out, "1 report: out/reports.html\n");
  study("out/deeper/two");
  EXPECT_EQ(run({"index", "out"}).out, "2 reports: out/reports.html\n");
  const std::string page = read("out/reports.html");
  EXPECT_THAT(page, HasSubstr("href=\"one/index.html\""));
  EXPECT_THAT(page, HasSubstr("href=\"deeper/two/index.html\""));
}

TEST_F(IndexCommand, AFolderThatIsNotThereIsBadInput) {
  const Finished refused = run({"index", "nowhere"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("nowhere"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "nowhere"));
}

}  // namespace
}  // namespace credence::internal
