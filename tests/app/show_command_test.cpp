// `credence show` and `credence report` as a user types them.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <filesystem>
#include <string>

#include "montecarlo/engine/result_store_sqlite.h"
#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

const std::string kShownSweep =
    "[world]\nmodel = \"monobot\"\n[study]\nruns = 100\nsteps = 20\n[sweep]\n\"world.landmarks\" = \"1:3\"\n";

class ShowCommand : public CommandTest {
 protected:
  /// The process of `arguments` as soon as it has stored something.
  pid_t running(const std::vector<std::string>& arguments, const fs::path& folder) const {
    const pid_t child = start(arguments);
    wait_for_chunks(folder);
    return child;
  }

  /// Runs a command beside one whose output is in the usual files.
  Finished beside(const std::string& arguments) const {
    const std::string command =
        "cd " + folder_.path().string() + " && " + credence_binary().string() + " " + arguments;
    const int status = std::system((command + " > other.out 2> other.err").c_str());
    return {WEXITSTATUS(status), read("other.out"), read("other.err")};
  }
};

TEST_F(ShowCommand, ShowSaysOfStoredRunsWhatRunSaid) {
  write("a.toml", kMonobot);
  const Json said = json({"run", "a.toml", "--out", "out", "--format", "json"});
  EXPECT_EQ(json({"show", "out", "--format", "json"}), said);
  const Finished text = run({"show", "out"});
  EXPECT_EQ(text.code, 0);
  EXPECT_NE(text.out.find("a: 300 of 300 runs are stored (100.0 %); made by version"), std::string::npos)
      << text.out;

  const Finished none = run({"show", "."});
  EXPECT_EQ(none.code, 0) << "the folder above shows all in it: " << none.err;
  fs::create_directory(folder_ / "empty");
  EXPECT_NE(run({"show", "empty"}).err.find("credence: empty: holds no stored results"), std::string::npos);
}

TEST_F(ShowCommand, ShowAndReportOfASweepThatIsRunningLeaveItAlone) {
  write("s.toml", kShownSweep);
  const Finished whole = run({"sweep", "s.toml", "--runs", "300000", "--out", "whole", "--format", "json"});
  ASSERT_EQ(whole.code, 0) << whole.err;
  const pid_t child = running(
      {"sweep", "s.toml", "--runs", "300000", "--out", "out", "--format", "json", "--threads", "1"}, "out");
  // It stands still while it is looked at, or it could be over before.
  Finished shown;
  wait_for([&] {
    kill(child, SIGSTOP);
    shown = beside("show out --quiet");
    if (shown.out.find(": 0 of") == std::string::npos) return true;
    kill(child, SIGCONT);
    return false;
  });
  const Finished reported = beside("report out --out so_far --quiet");
  ASSERT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "the sweep was over before it could be looked at";
  kill(child, SIGCONT);
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_NE(shown.out.find("of 900000 runs are stored"), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find("; process " + std::to_string(child) + " goes on"), std::string::npos)
      << shown.out;
  EXPECT_EQ(reported.code, 0) << reported.err;
  EXPECT_TRUE(fs::exists(folder_ / "so_far" / "index.html"));
  const Finished finished = finish(child);
  EXPECT_EQ(finished.code, 0) << finished.err;
  EXPECT_EQ(finished.out, whole.out);
  EXPECT_EQ(run({"show", "out"}).out.find("goes on"), std::string::npos);
}

// As of a shard, or of a file that lost its beginning.
TEST_F(ShowCommand, RunsBehindMissingOnesAreCountedAndSaidNotToBeJudged) {
  write("a.toml", kMonobot);
  write("s.toml", kShownSweep);
  ASSERT_EQ(run({"run", "a.toml", "--runs", "200", "--out", "out", "--quiet"}).code, 0);
  const auto shown = [&](const char* missing) {
    SqliteDatabase(folder_ / "out/results.sqlite", SqliteDatabase::Mode::create)
        .execute(fmt::format("DELETE FROM chunks WHERE first_run = {}", missing));
    return run({"show", "out"});
  };
  const Finished inner = shown("64");
  EXPECT_EQ(inner.code, 0) << inner.err;
  EXPECT_NE(
      inner.out.find("a: 136 of 200 runs are stored (68.0 %); 72 of them are not judged, as runs 64 to 127 "
                     "before them are missing; made by version"),
      std::string::npos)
      << inner.out;
  const Finished outer = shown("0");
  EXPECT_EQ(outer.code, 0) << outer.err;
  EXPECT_NE(
      outer.out.find("a: 72 of 200 runs are stored (36.0 %); 72 of them are not judged, as runs 0 to 127 "
                     "before them are missing; made by version"),
      std::string::npos)
      << outer.out;
  ASSERT_EQ(run({"sweep", "s.toml", "--shard", "2/2", "--out", "shard", "--quiet"}).code, 0);
  EXPECT_NE(run({"show", "shard"})
                .out.find("s: 108 of 300 runs are stored (36.0 %); 108 of them are not judged, as "
                          "others before them are missing; made by version"),
            std::string::npos);
  ASSERT_EQ(run({"run", "a.toml", "--runs", "100", "--out", "out", "--quiet"}).code, 0);
  EXPECT_NE(run({"show", "out"}).out.find("a: 100 of 100 runs are stored (100.0 %); made by version"),
            std::string::npos)
      << "those of more runs are not of this study";
}

TEST_F(ShowCommand, ReportKeepsWhatTheAuthorOfTheScenarioSays) {
  write("a.toml", std::string("# Two \"beacons\" & a robot.\n") + kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out"}).code, 0);
  const auto paragraphs = [&] {
    const std::string page = read("out/index.html");
    std::size_t found = 0;
    for (std::size_t at = page.find("<p>Two "); at != std::string::npos; at = page.find("<p>Two ", at + 1))
      ++found;
    return found;
  };
  EXPECT_EQ(paragraphs(), 1U);
  for (int again = 0; again < 2; ++again) {
    ASSERT_EQ(run({"report", "out", "--quiet"}).code, 0);
    EXPECT_EQ(paragraphs(), 1U) << again;
  }
}

TEST_F(ShowCommand, ReportMakesThePagesOfRunAgain) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out"}).code, 0);
  const std::string csv = read("out/a.csv");
  fs::remove(folder_ / "out" / "a.csv");
  ASSERT_EQ(run({"report", "out", "--quiet"}).code, 0);
  EXPECT_NE(read("out/index.html").find("content=\"credence run a.toml --out out\""), std::string::npos)
      << "what made the results";
  fs::remove(folder_ / "out" / "a.csv");
  fs::remove(folder_ / "out" / "index.html");
  const Finished f = run({"report", "out"});
  EXPECT_EQ(f.code, 0) << f.err;
  EXPECT_EQ(f.err, "Report: out/index.html\n");
  EXPECT_EQ(read("out/a.csv"), csv);
  EXPECT_NE(read("out/index.html").find("<svg"), std::string::npos);
}
TEST_F(ShowCommand, FiguresForAPaperAreMadeFromWhatIsStored) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out"}).code, 0);
  const Finished f = run({"report", "out", "--figures", "pgf,png,one-column"});
  ASSERT_EQ(f.code, 0) << f.err;
  EXPECT_TRUE(fs::exists(folder_ / "out" / "figures" / "panels" / "a-run-2.pgf"));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "figures" / "a-run.png"));
  EXPECT_NE(read("out/index.html").find("a-run.pgf\">PGF</a>"), std::string::npos);
  const Finished word = run({"report", "out", "--figures", "eps"});
  EXPECT_EQ(word.code, 2);
  EXPECT_NE(word.err.find("one-column"), std::string::npos) << "what is accepted: " << word.err;
  const Finished widths = run({"run", "a.toml", "--figures", "one-column,two-columns", "--out", "none"});
  EXPECT_EQ(widths.code, 2);
  EXPECT_NE(widths.err.find("one-column and two-columns exclude each other"), std::string::npos)
      << widths.err;
  EXPECT_FALSE(fs::exists(folder_ / "none"));
}

TEST_F(ShowCommand, ASweepAmongOtherStudiesIsNotMixedWithThem) {
  write("a.toml", kMonobot);
  write("s.toml", kShownSweep);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out/a", "--quiet"}).code, 0);
  const Json swept = json({"sweep", "s.toml", "--out", "out/s", "--quiet", "--format", "json"});
  for (const char* command : {"show", "report"}) {
    const Finished f = run({command, "out"});
    EXPECT_EQ(f.code, 2);
    EXPECT_EQ(f.err, "credence: out/s: is a sweep among other studies; name its folder alone\n");
  }
  EXPECT_EQ(json({"show", "out/s", "--format", "json"}), swept);
}

}  // namespace
}  // namespace credence::internal
