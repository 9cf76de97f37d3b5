#include "datasets/judged_states.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

RunLayout layout_with(std::vector<std::string> states) {
  RunLayout layout;
  layout.states = std::move(states);
  layout.has_truth = true;
  return layout;
}

Step step_with(std::vector<Index> states) { return {.step = 1, .states = std::move(states)}; }

TEST(JudgedStates, AStateThatNoRowJudgesIsNamed) {
  JudgedStates states;
  states.begin_run("a.csv", layout_with({"x", "bias", "y"}));
  states.add(step_with({0}));
  states.add(step_with({0, 2}));
  EXPECT_THAT(states.sentences(),
              ElementsAre("No row has an estimate and a truth of bias, which is not judged."));
  states.add(step_with({0, 1, 2}));
  EXPECT_THAT(states.sentences(), IsEmpty());
}

TEST(JudgedStates, OneThatAnyFileJudgesIsJudged) {
  JudgedStates first, second, all;
  first.begin_run("a.csv", layout_with({"x", "a", "b"}));
  first.add(step_with({0}));
  second.begin_run("b.csv", layout_with({"b", "x"}));
  second.add(step_with({0}));
  all.merge(first);
  EXPECT_THAT(all.sentences(),
              ElementsAre("No row has an estimate and a truth of a, b, which are not judged."));
  all.merge(second);
  EXPECT_THAT(all.sentences(), ElementsAre("No row has an estimate and a truth of a, which is not judged."));
}

TEST(JudgedStates, OfInnovationsAloneAndOfNoTruthAtAllNothingIsSaid) {
  JudgedStates states;
  states.begin_run("a.csv", {.states = {"x"}});
  EXPECT_THAT(states.sentences(), IsEmpty());
  states.begin_run("b.csv", layout_with({"x", "y"}));
  states.add(step_with({}));
  EXPECT_THAT(states.sentences(), IsEmpty()) << "no state is judged";
}

TEST(JudgedStates, TellWhereARunIsJudgedToItsEndNoMore) {
  JudgedStates states;
  states.begin_run("a.csv", layout_with({"x"}));
  for (std::int64_t step = 1; step <= 100; ++step)
    states.add({.step = step, .states = step <= 40 ? std::vector<Index>{0} : std::vector<Index>{}});
  states.end_run();
  EXPECT_THAT(states.sentences(), ElementsAre(::testing::HasSubstr("step 40 of 100"),
                                              "60 of 100 rows have no estimate with its truth."));
}

}  // namespace
}  // namespace credence::internal
