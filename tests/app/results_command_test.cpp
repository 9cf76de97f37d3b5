// What is done with stored results: show, compare, report.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "montecarlo/engine/result_store.h"
#include "tests/app/command.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

const std::string kMonobot = "[world]\nmodel = \"monobot\"\nlandmarks = 2\n[study]\nruns = 300\nsteps = 30\n";
const std::string kSweep =
    "[world]\nmodel = \"monobot\"\n[study]\nruns = 100\nsteps = 20\n[sweep]\n\"world.landmarks\" = \"1:3\"\n";

class ResultsCommand : public CommandTest {
 protected:
  /// The process of `arguments` as soon as it has stored something.
  pid_t running(const std::vector<std::string>& arguments, const fs::path& folder) const {
    const pid_t child = start(arguments);
    wait_for([&] {
      std::error_code none;
      const std::uintmax_t size = fs::file_size(folder_ / folder / "results.sqlite-wal", none);
      return !none && size > 60000;
    });
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

TEST_F(ResultsCommand, ShowSaysOfStoredRunsWhatRunSaid) {
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

TEST_F(ResultsCommand, ShowAndReportOfASweepThatIsRunningLeaveItAlone) {
  write("s.toml", kSweep);
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

TEST_F(ResultsCommand, ReportMakesThePagesOfRunAgain) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "out"}).code, 0);
  const std::string csv = read("out/a.csv");
  fs::remove(folder_ / "out" / "a.csv");
  fs::remove(folder_ / "out" / "index.html");
  const Finished f = run({"report", "out"});
  EXPECT_EQ(f.code, 0) << f.err;
  EXPECT_EQ(f.err, "Report: out/index.html\n");
  EXPECT_EQ(read("out/a.csv"), csv);
  EXPECT_NE(read("out/index.html").find("<svg"), std::string::npos);
}

TEST_F(ResultsCommand, CompareSetsVerdictsBesideEachOtherAndPairsRunsOfTheSameNoise) {
  write("a.toml", kMonobot);
  const Json first = json({"run", "a.toml", "--out", "a", "--format", "json"});
  ASSERT_EQ(run({"run", "a.toml", "--out", "b", "--set", "filter.measurement_scale=2.0"}).code, 0);
  ASSERT_EQ(run({"run", "a.toml", "--out", "c", "--seed", "2"}).code, 0);
  const Json studies = json({"compare", "a", "b", "c", "a", "--format", "json"})["studies"];
  ASSERT_EQ(studies.size(), 4U);
  EXPECT_EQ(studies[0]["verdict"], "consistent");
  EXPECT_EQ(studies[1]["verdict"], "pessimistic");
  EXPECT_EQ(studies[0]["nees"]["mean"], first["nees"]["mean"]);
  EXPECT_EQ(studies[1]["name"], "a (b)") << "two of one name are told apart";
  const double dof = first["nees"]["expected"];
  const double difference =
      (studies[1]["nees"]["mean"].get<double>() - studies[0]["nees"]["mean"].get<double>()) / dof;
  EXPECT_NEAR(studies[1]["paired_difference"]["value"].get<double>(), difference, 1e-12);
  EXPECT_LT(studies[1]["paired_difference"]["upper"], 0.0);
  EXPECT_TRUE(studies[2]["paired_difference"].is_null()) << "another seed is other noise";
  EXPECT_EQ(studies[3]["paired_difference"]["lower"], 0.0) << "itself";

  write("a.json", first.dump());
  const Json documents = json({"compare", "a.json", "b", "--format", "json"})["studies"];
  EXPECT_EQ(documents[0]["nees"]["mean"], first["nees"]["mean"]);
  EXPECT_NE(run({"compare", "a", "b"}).out.find("against the first"), std::string::npos);
  EXPECT_EQ(run({"compare", "a"}).code, 2);
  write("no.json", "{\"schema\": 1}");
  EXPECT_NE(run({"compare", "a", "no.json"}).err.find("no.json: is no document of"), std::string::npos);
}

TEST_F(ResultsCommand, AfterAnInterruptionTheCommandThatContinuesIsToldAndDoesSo) {
  write("a b.toml", kMonobot);
  const pid_t child = running({"run", "a b.toml", "--fresh", "--runs", "100000000", "--out", "out"}, "out");
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  const std::string told = credence_binary().string() + " run 'a b.toml' --runs 100000000 --out out\n";
  EXPECT_TRUE(f.err.ends_with(told)) << f.err << "\nmust end with " << told;
}

}  // namespace
}  // namespace credence::internal
