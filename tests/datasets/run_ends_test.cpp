#include "datasets/run_ends.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr const char* kFailure =
    " If the filter failed there, that is not counted: docs/formats.md says how a log tells it.";

struct Rows {
  std::int64_t steps = 100;
  std::int64_t judged_to = steps;
  std::int64_t every = 1;  ///< only such steps are judged
  bool failed = false;
};

RunEnds ends_of(const std::vector<Rows>& runs, std::size_t first = 0) {
  RunEnds ends;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    ends.begin_run(fmt::format("run {}", first + i), true);
    for (std::int64_t step = 1; step <= runs[i].steps; ++step)
      ends.add(step, step <= runs[i].judged_to && step % runs[i].every == 0);
    if (runs[i].failed) ends.failed();
  }
  ends.end_run();
  return ends;
}

TEST(RunEnds, OfRunsThatAreWholeNothingIsSaid) {
  EXPECT_THAT(ends_of(std::vector<Rows>(20)).sentences(), IsEmpty());
  EXPECT_THAT(ends_of({{.steps = 100, .judged_to = 91}}).sentences(), IsEmpty()) << "its last rows alone";
  EXPECT_THAT(ends_of({{.steps = 100, .judged_to = 100, .every = 30}}).sentences(), IsEmpty())
      << "no longer than it was silent before";
}

TEST(RunEnds, ARunWithoutEstimatesToItsEndIsNamed) {
  EXPECT_THAT(
      ends_of({{}, {.steps = 100, .judged_to = 50}, {.steps = 100, .judged_to = 30}}).sentences(),
      ElementsAre(std::string("2 of 3 runs have rows on after the last with an estimate and its truth "
                              "(run 1 and 1 more: step 50 of 100).") +
                  kFailure));
}

TEST(RunEnds, ARunThatEndsBeforeTheOthersIsNamed) {
  std::vector<Rows> runs(20);
  runs[3].steps = runs[3].judged_to = 60;
  runs[7].steps = runs[7].judged_to = 97;
  EXPECT_THAT(ends_of(runs).sentences(),
              ElementsAre(std::string("1 of 20 runs ends early (run 3: after 60 of the 100 steps of the "
                                      "others).") +
                          kFailure));
}

TEST(RunEnds, RunsOfManyLengthsAndThoseThatSayThatTheyFailedAreNoMatter) {
  std::vector<Rows> runs;
  for (std::int64_t i = 0; i < 20; ++i) runs.push_back({.steps = 50 + 10 * (i % 4)});
  EXPECT_THAT(ends_of(runs).sentences(), IsEmpty());
  runs.assign(20, Rows{});
  runs[3] = {.steps = 60, .judged_to = 20, .failed = true};
  EXPECT_THAT(ends_of(runs).sentences(), IsEmpty());
}

TEST(RunEnds, RunsOfPartsAreThoseOfTheWhole) {
  std::vector<Rows> runs(20);
  runs[3].steps = 60;
  runs[3].judged_to = 20;
  runs[12].steps = runs[12].judged_to = 70;
  RunEnds parts = ends_of({runs.begin(), runs.begin() + 8});
  parts.merge(ends_of({runs.begin() + 8, runs.end()}, 8));
  EXPECT_EQ(parts.sentences(), ends_of(runs).sentences());
  EXPECT_EQ(parts.sentences().size(), 2U);
}

}  // namespace
}  // namespace credence::internal
