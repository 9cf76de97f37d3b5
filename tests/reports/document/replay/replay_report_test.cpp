#include "reports/document/replay/replay_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "reports/render/text_page.h"
#include "tests/datasets/replay/replay_world.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Document document_of(std::vector<ReportedReplay> replays) {
  for (ReportedReplay& replay : replays) replay.result.dataset = "mrclam";
  return replay_document(replays, judge_replays(replays));
}

// Range noise of twice what R says: S is too small, and the answer is that of the judge of logs.
TEST(ReplayReport, AnswersAsTheJudgeOfLogsDoes) {
  const Document document = document_of({{test::ReplayWorld().run(1, 60, 2.0), {}}});
  EXPECT_EQ(document.answer.tone, CellTone::alarm);
  EXPECT_THAT(document.answer.text, HasSubstr("Can this covariance be trusted? No: optimistic in NIS"));
  EXPECT_EQ(document.title, "EKF-SLAM on mrclam");
  EXPECT_THAT(text_page(document), AllOf(HasSubstr("Scaling S by"), HasSubstr("the map as it lies"),
                                         HasSubstr("mean NIS of an observation")));
}

TEST(ReplayReport, ItsJsonHasTheVerdictAndWhatItRestsOn) {
  const Document document = document_of({{test::ReplayWorld().run(1, 60, 2.0), {}}});
  const auto j = nlohmann::json::parse(document.json())["judgement"];
  EXPECT_EQ(j["verdict"], "optimistic");
  EXPECT_EQ(j["innovations"]["nis"]["verdict"], "optimistic");
  EXPECT_EQ(j["innovations"]["nis"]["values"], 236);
  ASSERT_EQ(j["innovations"]["adjusted_p_value"].size(), 4U);
  EXPECT_LT(j["innovations"]["adjusted_p_value"][0], 0.05);
  EXPECT_EQ(j["innovations"]["noise_scale"]["value"], j["battery"]["scale"]["innovation"]["factor"]);
  EXPECT_EQ(j["nees"]["run_means"].size(), 1U);
  EXPECT_EQ(j["maps"][0]["shape"]["dof"], 5);
  EXPECT_FALSE(j["limits"].empty());
}

TEST(ReplayReport, SeveralRunsHaveOneTableAndOneVerdict) {
  std::vector<ReportedReplay> replays(2);
  for (unsigned i = 0; i < 2; ++i) {
    replays[i].result = test::ReplayWorld().run(i + 1, 60);
    replays[i].result.run = i == 0 ? "robot 1" : "robot 3";
  }
  const Document document = document_of(replays);
  EXPECT_THAT(text_page(document),
              AllOf(HasSubstr("2 runs"), HasSubstr("mrclam, robot 3"), HasSubstr("robot 3: its shape")));
  EXPECT_EQ(nlohmann::json::parse(document.json())["runs"].size(), 2U);
}

}  // namespace
}  // namespace credence::internal
