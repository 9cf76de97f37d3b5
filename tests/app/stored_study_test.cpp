// Which stored studies a path means, and what is said of those without runs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <string>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class StoredStudies : public CommandTest {};

TEST_F(StoredStudies, OfAFolderAreThoseInItInTheOrderOfTheirNames) {
  write("b.toml", kMonobot);
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "b.toml", "a.toml", "--runs", "64", "--out", "out", "--quiet"}).code, 0);
  write("out/notes.txt", "no study");
  fs::create_directories(folder_ / "out/c");
  const Json both = json({"show", "out", "--format", "json"});
  ASSERT_EQ(both["studies"].size(), 2U);
  EXPECT_EQ(both["studies"][0]["scenario"]["name"], "a");
  EXPECT_EQ(both["studies"][1]["scenario"]["name"], "b");
  EXPECT_EQ(json({"compare", "out", "--format", "json"})["studies"].size(), 2U) << "a folder is two results";
  EXPECT_EQ(json({"show", "out/b", "--format", "json"})["scenario"]["name"], "b");
}

TEST_F(StoredStudies, WhereThereAreNoneIsBadInput) {
  fs::create_directories(folder_ / "empty");
  write("file", "no folder");
  for (const std::string path : {"empty", "file", "nowhere"}) {
    for (const char* command : {"show", "report"}) {
      const Finished f = run({command, path});
      EXPECT_EQ(f.code, 2);
      EXPECT_EQ(f.err,
                "credence: " + path +
                    ": holds no stored results; run and sweep make such folders, with --out (other commands "
                    "make their pages and figures again when they are run again; of `check` the document of "
                    "--format json is compared)\n");
      EXPECT_EQ(f.out, "");
    }
  }
}

TEST_F(StoredStudies, WithoutRunsYetAreShownButMakeNoReport) {
  write("p.toml", kLongChunk);
  const pid_t child = start({"run", "p.toml", "--out", "out", "--quiet"});
  wait_until_caught(child);
  kill(child, SIGINT);
  ASSERT_EQ(finish(child).code, 130);
  const Finished shown = run({"show", "out"});
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("p: 0 of 64 runs are stored (0.0 %); made by version "));
  for (const auto& arguments : {std::vector<std::string>{"report", "out"}, {"compare", "out", "out"}}) {
    const Finished f = run(arguments);
    EXPECT_EQ(f.code, 2);
    EXPECT_EQ(f.err, "credence: out: no runs are stored yet\n");
  }
  EXPECT_FALSE(fs::exists(folder_ / "out/index.html"));
}

TEST_F(StoredStudies, HaveTheNameOfTheirScenarioWhereverTheyAre) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out", "--quiet"}).code, 0);
  const std::string before = run({"show", "out", "--format", "json"}).out;
  fs::rename(folder_ / "out", folder_ / "moved");
  EXPECT_EQ(run({"show", "moved", "--format", "json"}).out, before);
  EXPECT_EQ(run({"show", "moved/", "--format", "json"}).out, before);
}

}  // namespace
}  // namespace credence::internal
