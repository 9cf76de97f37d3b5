// `credence world` as a user types it: rows for a filter in any language.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

class WorldCommand : public CommandTest {};

// The same filter in C, by binary frames, and built in: the pipe keeps every bit, and sums are in another
// order.
TEST_F(WorldCommand, AFilterInAnotherLanguageHasItsVerdictThroughThePipe) {
  const std::string folder = (source_folder() / "examples/pipe").string(),
                    walk = folder + "/random_walk.toml";
  const Finished made =
      finish(start_program({"cc", "-std=c99", "-O1", "-o", "my_filter", folder + "/my_filter.c"}));
  if (made.code != 0) GTEST_SKIP() << "no C compiler: " << made.err;
  const std::string credence = credence_binary().string();
  const Finished piped = finish(start_program(
      {"sh", "-c",
       credence + " world " + walk + " --frames | ./my_filter | " + credence + " check - --format json"}));
  ASSERT_EQ(piped.code, 0) << piped.err;
  const Json judged = Json::parse(piped.out), wanted = json({"run", walk, "--format", "json"});
  EXPECT_EQ(judged["verdict"], wanted["verdict"]);
  for (const char* of : {"nees", "nis"}) {
    EXPECT_NEAR(judged[of]["mean"].get<double>(), wanted[of]["mean"].get<double>(), 1e-9) << of;
  }
}

TEST_F(WorldCommand, FramesAreTheRowsOfTheText) {
  const std::vector<std::string> command = {"world", scenario_file("pendulum"), "--runs", "2", "--steps",
                                            "3"};
  std::vector<std::string> binary = command;
  binary.emplace_back("--frames");
  const std::string text = run(command).out, frames = run(binary).out;
  const auto body = [](const std::string& all) { return all.substr(all.find("run,step")); };
  const std::string names = body(text).substr(0, body(text).find('\n') + 1);
  EXPECT_THAT(frames, ::testing::StartsWith("# credence frames 1\n"));
  EXPECT_THAT(body(frames), ::testing::StartsWith(names));
  const auto columns = static_cast<std::size_t>(std::ranges::count(names, ',')) + 1;
  EXPECT_EQ(body(frames).size() - names.size(), 2 * 4 * columns * sizeof(double));
  EXPECT_EQ(std::ranges::count(body(text), '\n'), 1 + 2 * 4);
}

// x doubles at every step, and z is three times x: no noise but that of the start.
TEST_F(WorldCommand, RowsAreTheWorldOfTheScenario) {
  write("w.toml",
        "[world]\nmodel = \"linear\"\nF = [[2]]\nH = [[3]]\nQ = [[0]]\nR = [[1e-12]]\nP0 = [[1]]\n"
        "[study]\nruns = 2\nsteps = 3\n");
  const std::string text = run({"world", "w.toml"}).out;
  EXPECT_THAT(text, ::testing::StartsWith("# [world]\n# model = \"linear\"\n# F = [[2.0]]\n"));
  std::istringstream lines(text.substr(text.find("run,step")));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "run,step,prior.x1,truth.x1,measurement.1");
  double before = 0.0;
  for (int row = 0; std::getline(lines, line); ++row) {
    std::istringstream fields(line);
    std::vector<std::string> values;
    for (std::string value; std::getline(fields, value, ',');) values.push_back(value);
    ASSERT_LT(row, 8);
    ASSERT_GE(values.size(), 4U) << line;
    EXPECT_EQ(values[0], std::to_string(row / 4));
    EXPECT_EQ(values[1], std::to_string(row % 4));
    const double truth = std::stod(values[3]);
    if (row % 4 == 0) {
      EXPECT_EQ(values[2], "0") << "the filter starts there";
      EXPECT_TRUE(line.ends_with(',')) << "nothing is measured yet: " << line;
    } else {
      EXPECT_EQ(values[2], "");
      EXPECT_DOUBLE_EQ(truth, 2.0 * before);
      EXPECT_NEAR(std::stod(values.at(4)), 3.0 * truth, 1e-5) << "ten standard deviations";
    }
    before = truth;
  }
}

// The rows come from the experiment, whose filter is the one of the scenario.
TEST_F(WorldCommand, AFilterThatFailsEndsTheStreamWithAnError) {
  write("w.toml",
        "[world]\nmodel = \"linear\"\nF = [[2]]\nH = [[3]]\nQ = [[0]]\nR = [[0]]\nP0 = [[1]]\n"
        "[study]\nruns = 2\nsteps = 3\n");
  const Finished f = run({"world", "w.toml"});
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.err,
            "credence: w.toml: run 0 ends at step 2, where the filter of the scenario fails "
            "(not_positive_definite)\n");
  EXPECT_THAT(f.out, ::testing::EndsWith("\n0,1,,0.1675666764928641,0.5027000294785924\n"))
      << "what the failed step has left is no row";
}

TEST_F(WorldCommand, TheSeedTellsTheNoise) {
  const auto rows = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all{"world", "pendulum", "--steps", "3"};
    all.insert(all.end(), more.begin(), more.end());
    const std::string text = run(all).out;
    return text.substr(text.find("run,step"));
  };
  const std::string first = rows({"--runs", "1"});
  EXPECT_EQ(rows({"--runs", "1", "--seed", "1"}), first);
  EXPECT_NE(rows({"--runs", "1", "--seed", "2"}), first);
  // Run 0 is the same among others.
  EXPECT_THAT(rows({"--runs", "3"}), ::testing::StartsWith(first));
}

TEST_F(WorldCommand, AnInterruptionEndsItAfterAWholeRun) {
  const pid_t child = start({"world", "pendulum", "--runs", "100000000", "--steps", "3"});
  wait_for([&] { return read("stdout").size() > 100000; });
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  EXPECT_TRUE(f.out.ends_with("\n"));
  const std::string last = f.out.substr(f.out.rfind('\n', f.out.size() - 2) + 1);
  EXPECT_EQ(last.substr(last.find(','), 3), ",3,") << last;
}

}  // namespace
}  // namespace credence::internal
