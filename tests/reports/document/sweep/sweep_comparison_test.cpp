#include "reports/document/sweep/sweep_comparison.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

ComparedStudy cell(std::int64_t of_sweep, const std::string& name, double factor) {
  return {.name = "s",
          .runs = 100,
          .verdict = "consistent",
          .factor = {.mean = factor, .lower = factor / 1.1, .upper = factor * 1.1},
          .cell = name,
          .of_sweep = of_sweep,
          .confidence = 0.95};
}

// z = log(1.5) / (√2 log(1.1) / 1.96) = 5.9, and log(1.05) / … = 0.7.
TEST(SweepComparison, TellsWhichConfigurationsDiffer) {
  const std::vector<ComparedStudy> studies = {cell(0, "a = 1", 1.0), cell(0, "a = 2", 1.0),
                                              cell(1, "a = 2", 1.5), cell(1, "a = 1", 1.05),
                                              cell(1, "a = 3", 2.0)};
  EXPECT_TRUE(are_of_sweeps(studies));
  const auto changes = changes_from_first(studies, 0.95);
  ASSERT_EQ(changes[2].size(), 1U);
  EXPECT_NEAR(changes[2][0].ratio.mean, 1.5, 1e-12);
  EXPECT_LT(changes[2][0].adjusted, 1e-7);
  EXPECT_GT(changes[3].at(0).adjusted, 0.4);
  EXPECT_TRUE(changes[4].empty()) << "the first sweep has no such configuration";
  const Document document = sweep_comparison_document(studies, 0.95);
  EXPECT_EQ(document.answer.text,
            "Of 2 configurations 1 differs by more than chance: 0 nearer to right, 1 farther: a = 2");
}

TEST(SweepComparison, NamesThreeAndCountsTheOthers) {
  std::vector<ComparedStudy> studies;
  for (const std::int64_t sweep : {0, 1}) {
    for (const char* name : {"1", "2", "3", "4", "5"})
      studies.push_back(cell(sweep, name, sweep == 0 ? 1.0 : 2.0));
  }
  EXPECT_EQ(
      sweep_comparison_document(studies, 0.95).answer.text,
      "Of 5 configurations 5 differ by more than chance: 0 nearer to right, 5 farther: 1; 2; 3 and 2 more");
}

}  // namespace
}  // namespace credence::internal
