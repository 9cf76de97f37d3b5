#include "reports/document/sweep/planar_table_report.h"

#include <gmock/gmock.h>

#include <vector>

namespace credence::internal {
namespace {

Document table_document(const std::vector<LongRun>& verdicts) {
  PlanarStability analysis;
  for (const LongRun verdict : verdicts) {
    PlanarFollowed followed;
    followed.at = Linearisation::truth;
    followed.growth.verdict = verdict;
    analysis.followed.push_back(followed);
  }
  SweepPlan plan;
  plan.points.resize(1);
  return planar_table_document(plan, {analysis});
}

ReportAnswer answer_of(const std::vector<LongRun>& verdicts) { return table_document(verdicts).answer; }

TEST(PlanarTableReport, OthersGrowOnlyWhereThereAreOthers) {
  using enum LongRun;
  EXPECT_EQ(answer_of({bounded, growing, growing}).text,
            "With Jacobians at the truth P stays bounded in 1 of 3 filters, and grows in the others");
  EXPECT_EQ(
      answer_of({bounded, growing, failed}).text,
      "With Jacobians at the truth P stays bounded in 1 of 3 filters, grows in 1 and leaves all bounds in 1");
  EXPECT_EQ(answer_of({failed}).text,
            "With Jacobians at the truth P stays bounded in none of 1 filter, and leaves all bounds in 1");
  EXPECT_EQ(answer_of({bounded}).text, "With Jacobians at the truth P stays bounded in the one filter");
  EXPECT_EQ(answer_of({bounded, bounded}).text,
            "With Jacobians at the truth P stays bounded in all 2 filters");
  EXPECT_EQ(answer_of({bounded, bounded}).tone, CellTone::good);
  EXPECT_EQ(answer_of({growing}).text, "With Jacobians at the truth P stays bounded in none of 1 filter");
  EXPECT_EQ(answer_of({growing}).tone, CellTone::caution);
}

TEST(PlanarTableReport, ATerminalShowsTheAnswer) {
  EXPECT_EQ(std::get<std::string>(table_document({LongRun::growing}).brief.front()),
            "With Jacobians at the truth P stays bounded in none of 1 filter.");
}

}  // namespace
}  // namespace credence::internal
