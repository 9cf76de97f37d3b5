#include "datasets/judged_states.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

RunLayout layout_with(std::vector<std::string> states) {
  RunLayout layout;
  layout.states = std::move(states);
  layout.has_truth = true;
  return layout;
}

TEST(JudgedStates, AStateThatNoRowJudgesIsNamed) {
  JudgedStates states;
  states.begin_run(layout_with({"x", "bias", "y"}));
  states.add(std::vector<Index>{0});
  states.add(std::vector<Index>{0, 2});
  EXPECT_EQ(states.sentence(), "No row has an estimate and a truth of bias, which is not judged.");
  states.add(std::vector<Index>{0, 1, 2});
  EXPECT_EQ(states.sentence(), "");
}

TEST(JudgedStates, OneThatAnyFileJudgesIsJudged) {
  JudgedStates first, second, all;
  first.begin_run(layout_with({"x", "a", "b"}));
  first.add(std::vector<Index>{0});
  second.begin_run(layout_with({"b", "x"}));
  second.add(std::vector<Index>{0});
  all.merge(first);
  EXPECT_EQ(all.sentence(), "No row has an estimate and a truth of a, b, which are not judged.");
  all.merge(second);
  EXPECT_EQ(all.sentence(), "No row has an estimate and a truth of a, which is not judged.");
}

TEST(JudgedStates, OfInnovationsAloneAndOfNoTruthAtAllNothingIsSaid) {
  JudgedStates states;
  states.begin_run({.states = {"x"}});
  EXPECT_EQ(states.sentence(), "");
  states.begin_run(layout_with({"x", "y"}));
  states.add({});
  EXPECT_EQ(states.sentence(), "") << "no state is judged";
}

}  // namespace
}  // namespace credence::internal
