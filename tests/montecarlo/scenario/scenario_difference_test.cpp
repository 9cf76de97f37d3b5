#include "montecarlo/scenario/scenario_difference.h"

#include <gtest/gtest.h>

#include <string>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"

namespace credence::internal {
namespace {

std::string canonical(const std::vector<std::string>& overrides) {
  return canonical_toml(load_scenario_text("[world]\nmodel = \"monobot\"\n", "x.toml", overrides));
}

TEST(ScenarioDifference, what_extends_a_study_is_none) {
  const std::string stored = canonical({});
  for (const char* same : {"study.runs=7", "study.confidence=0.9", "study.stop.verdict=either",
                           "study.stop.max_runs=9", "study.stop.precision=0.1"}) {
    EXPECT_EQ(scenario_difference(stored, canonical({same})), "") << same;
    EXPECT_EQ(scenario_difference(canonical({same}), stored), "") << same;
  }
  EXPECT_EQ(scenario_difference(stored, canonical({"study.seed=2", "study.runs=7"})),
            "- study.seed = 1\n+ study.seed = 2\n");
}

TEST(ScenarioDifference, keys_of_one_name_are_told_apart_by_their_section) {
  EXPECT_EQ(scenario_difference("[a]\nx = 1\n[b]\nx = 2\n", "[a]\nx = 2\n[b]\nx = 1\n"),
            "- a.x = 1\n+ a.x = 2\n- b.x = 2\n+ b.x = 1\n");
  EXPECT_EQ(scenario_difference("[a]\nruns = 1\n", "[a]\nruns = 2\n"), "- a.runs = 1\n+ a.runs = 2\n")
      << "only those of [study] are passed over";
}

TEST(ScenarioDifference, a_value_may_hold_an_equals_sign_or_a_bracket) {
  EXPECT_EQ(scenario_difference("[w]\nstates = [\"a = b\"]\n", "[w]\nstates = [\"a = c\"]\n"),
            "- w.states = [\"a = b\"]\n+ w.states = [\"a = c\"]\n");
  EXPECT_EQ(scenario_difference("[w]\nF = [[1.0]]\nH = [[2.0]]", "[w]\nF = [[1.0]]\nH = [[3.0]]"),
            "- w.H = [[2.0]]\n+ w.H = [[3.0]]\n");
}

TEST(ScenarioDifference, the_empty_text_has_no_keys) {
  EXPECT_EQ(scenario_difference("", ""), "");
  EXPECT_EQ(scenario_difference("", "\n[a]\n\nx = 1"), "+ a.x = 1\n");
  EXPECT_EQ(scenario_difference("[a]\nx = 1", ""), "- a.x = 1\n");
}

}  // namespace
}  // namespace credence::internal
