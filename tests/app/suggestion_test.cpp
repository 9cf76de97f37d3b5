// What is proposed for a word that the command line does not know.

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

class Suggestion : public CommandTest {
 protected:
  void expect_said(const std::vector<std::pair<std::vector<std::string>, std::string>>& cases) const {
    for (const auto& [arguments, message] : cases) {
      const Finished f = run(arguments);
      EXPECT_EQ(f.code, 2) << message;
      EXPECT_EQ(f.out, "") << message;
      EXPECT_EQ(f.err, "credence: " + message + "\n");
    }
  }
};

TEST_F(Suggestion, OfACommandIsTheClosestUnlessNoneIsClose) {
  expect_said({{{"rnu"}, "no command is called rnu; did you mean run?"},
               {{"help", "swep"}, "help: no command is called swep; did you mean sweep?"},
               {{"estimator"}, "no command is called estimator; did you mean estimators?"},
               {{"xyzzy"}, "no command is called xyzzy; credence help lists all"},
               {{"xx"}, "no command is called xx; credence help lists all"},
               {{std::string(10000, 'r')},
                "no command is called " + std::string(10000, 'r') + "; credence help lists all"}});
}

TEST_F(Suggestion, OfAnOptionIsTheClosestOrTheKeyOfAScenarioThatIsCalledSo) {
  const auto of_run = [](const std::string& option, const std::string& proposal) {
    return std::pair{std::vector<std::string>{"run", "planar_loop", option, "20"},
                     "run: " + option + " is not expected" + proposal + " (credence help run)"};
  };
  expect_said({of_run("--thread", "; did you mean --threads?"),
               of_run("--step", "; did you mean --steps?"),
               of_run("--zzzzzz", ""),
               of_run("--landmarks", "; did you mean --set world.landmarks=VALUE?"),
               of_run("--world.landmarks", "; did you mean --set world.landmarks=VALUE?"),
               of_run("--json", "; did you mean --format json?"),
               of_run("--measurement-scale", "; did you mean --set filter.measurement_scale=VALUE?"),
               // Of a command that takes no settings.
               {{"check", "a.csv", "--landmarks", "20"},
                "check: --landmarks is not expected (credence help check)"}});
}

}  // namespace
}  // namespace credence::internal
