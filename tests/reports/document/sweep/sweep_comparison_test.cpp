#include "reports/document/sweep/sweep_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

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

// ln 1.25 and ln 0.8 are as far from right: the point estimates alone would have called 0.79 farther.
TEST(SweepComparison, WhatChangesSidesIsNotToldToBeNearer) {
  const std::vector<ComparedStudy> studies = {cell(0, "a = 1", 1.25), cell(0, "a = 2", 2.0),
                                              cell(1, "a = 1", 0.79), cell(1, "a = 2", 1.0)};
  const Document document = sweep_comparison_document(studies, 0.95);
  EXPECT_EQ(
      document.answer.text,
      "Of 2 configurations 2 differ by more than chance: 1 nearer to right, 1 of which that is not told, 0 "
      "farther");
  EXPECT_EQ(document.answer.tone, CellTone::caution);
}

// Run by run 1.2 became 1.5 and 0.75.
TEST(SweepComparison, PairedRunsTellWhichIsNearer) {
  const auto with = [](std::int64_t of_sweep, double nees) {
    ComparedStudy study = cell(of_sweep, "a = 1", nees);
    study.factor.mean = std::nan("");
    study.noise = "w";
    for (int run = 0; run < 40; ++run)
      study.nees_of_runs.push_back(nees + 0.01 * (run % (of_sweep == 0 ? 4 : 3)));
    return study;
  };
  const auto answer = [&](double before, double after) {
    const std::vector<ComparedStudy> studies = {with(0, before), with(1, after)};
    return sweep_comparison_document(studies, 0.95).answer.text;
  };
  const std::string differs = "Of 1 configuration 1 differs by more than chance: ";
  EXPECT_EQ(answer(1.2, 1.5), differs + "0 nearer to right, 1 farther: a = 1");
  EXPECT_EQ(answer(1.5, 1.2), differs + "1 nearer to right, 0 farther");
  EXPECT_EQ(answer(1.2, 0.775), differs + "0 nearer to right, 1 of which that is not told, 0 farther");
}

TEST(SweepComparison, WithoutCommonPointsThereIsNoTable) {
  const std::vector<ComparedStudy> studies = {cell(0, "a = 1", 1.0), cell(1, "b = 1", 1.0)};
  const Document document = sweep_comparison_document(studies, 0.95);
  EXPECT_EQ(document.answer.text,
            "Nothing can be compared: no configuration of one has the swept values of another");
  ASSERT_FALSE(document.brief.empty());
  EXPECT_EQ(
      std::get<std::string>(document.brief.back()),
      "1 configuration cannot be compared: the first sweep has none with the same swept values, or too few "
      "runs.");
  for (const DocumentPart& part : document.parts())
    EXPECT_FALSE(std::holds_alternative<ReportTable>(part)) << "of a heading alone";
}

}  // namespace
}  // namespace credence::internal
