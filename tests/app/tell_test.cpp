// What a command gives: the result on stdout, then the page, and where it is on stderr.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <filesystem>
#include <string>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"
#include "tests/app/unread_output.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class Tell : public CommandTest {
 protected:
  void SetUp() override { write("a.toml", kMonobot); }
};

TEST_F(Tell, OfAReportWhereItIsUnlessThatIsNotWanted) {
  EXPECT_EQ(run({"run", "a.toml", "--out", "one"}).err, "Report: one/index.html\n");
  EXPECT_EQ(run({"run", "a.toml", "--out", "two", "--quiet"}).err, "");
  EXPECT_TRUE(fs::exists(folder_ / "two/index.html"));
  EXPECT_EQ(run({"run", "a.toml"}).err, "");
  EXPECT_EQ(folder_.entries(), 5) << "the scenario, two folders, and what is said";
}

TEST_F(Tell, AsJsonIsOneDocumentAndTheEndOfALine) {
  const std::string out = run({"run", "a.toml", "--out", "out", "--format", "json"}).out;
  EXPECT_TRUE(Json::accept(out));
  EXPECT_TRUE(out.starts_with("{") && out.ends_with("}\n"));
}

// A page may take long, and it may fail: the result is told before.
TEST_F(Tell, TheResultComesBeforeThePage) {
  const UnreadOutput output(folder_);
  const pid_t child =
      start({"run", "a.toml", "--runs", "2", "--steps", "1000", "--out", "out", "--format", "json"});
  wait_for([&] { return output.has_begun(); });
  EXPECT_FALSE(fs::exists(folder_ / "out/index.html"));
  const std::string text = output.read_all();
  EXPECT_EQ(Json::parse(text)["steps"], 1000);
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(fs::exists(folder_ / "out/index.html"));
}

TEST_F(Tell, TheResultIsThereWhereThePageCannotBeWritten) {
  fs::create_directories(folder_ / "out/index.html");
  const Finished f = run({"run", "a.toml", "--out", "out", "--format", "json"});
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(Json::parse(f.out)["runs"], 300);
  EXPECT_THAT(f.err, ::testing::StartsWith("credence: cannot write 'out/index.html': "));
}

}  // namespace
}  // namespace credence::internal
