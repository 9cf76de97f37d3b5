#include "reports/document/logs/log_contents_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "reports/render/text_page.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::vector<ListedLog> listed_logs() {
  return {{.file = "a.bag",
           .format = "ROS 1 bag",
           .contents = {.topics = {{.name = "/odom",
                                    .type = "nav_msgs/Odometry",
                                    .count = 1234,
                                    .rate_hz = 49.96,
                                    .use = "estimate",
                                    .covariance = true},
                                   {.name = "/tf", .type = "tf2_msgs/TFMessage", .count = 1}},
                        .remark = "One chunk is broken."}},
          {.file = "b.npz", .format = "NumPy", .contents = {}}};
}

TEST(LogContentsReport, EachLogHasATableOfItsTopics) {
  const Document document = contents_document(listed_logs());
  ASSERT_EQ(document.brief.size(), 2U);
  const auto& table = std::get<ReportTable>(document.brief[0]);
  EXPECT_EQ(table.title, "a.bag (ROS 1 bag)");
  std::vector<std::string> first, second;
  for (const TableCell& cell : table.rows.at(0)) first.push_back(cell.text);
  for (const TableCell& cell : table.rows.at(1)) second.push_back(cell.text);
  EXPECT_THAT(first, ElementsAre("/odom", "nav_msgs/Odometry", "1234", "50.0", "yes", "estimate"));
  EXPECT_THAT(second, ElementsAre("/tf", "tf2_msgs/TFMessage", "1", "–", "–", "–"));
  EXPECT_THAT(table.notes, ElementsAre("One chunk is broken."));
  EXPECT_TRUE(std::get<ReportTable>(document.brief[1]).rows.empty());
  EXPECT_TRUE(std::get<ReportTable>(document.brief[1]).notes.empty());
}

TEST(LogContentsReport, WhatCanBeJudgedComesFirst) {
  std::vector<ListedLog> logs = listed_logs();
  std::vector<LogTopic>& topics = logs[0].contents.topics;
  topics = {{.name = "/tf", .count = 5}, {.name = "/empty", .use = "estimate"}, topics[0]};
  const Document document = contents_document(logs);
  std::vector<std::string> names;
  for (const auto& row : std::get<ReportTable>(document.brief[0]).rows) names.push_back(row.at(0).text);
  EXPECT_THAT(names, ElementsAre("/odom", "/tf", "/empty"));
}

TEST(LogContentsReport, TheDataSayTheSame) {
  const auto j = nlohmann::json::parse(contents_document(listed_logs()).json());
  ASSERT_EQ(j["logs"].size(), 2U);
  const auto& topics = j["logs"][0]["topics"];
  ASSERT_EQ(topics.size(), 2U);
  EXPECT_EQ(topics[0]["name"], "/odom");
  EXPECT_EQ(topics[0]["messages"], 1234);
  EXPECT_EQ(topics[0]["rate_hz"], 49.96);
  EXPECT_EQ(topics[0]["covariance"], true);
  EXPECT_EQ(topics[0]["use"], "estimate");
  EXPECT_TRUE(topics[1]["rate_hz"].is_null());
  EXPECT_EQ(topics[1]["use"], "");
  EXPECT_TRUE(j["logs"][1]["topics"].is_array());
  EXPECT_EQ(j["logs"][0]["remark"], "One chunk is broken.");
  EXPECT_FALSE(j["null_reason"].empty());
}

// Names of topics are other people's bytes.
TEST(LogContentsReport, HostileNamesNeitherReachATerminalNorBreakTheData) {
  std::vector<ListedLog> logs = listed_logs();
  logs[0].contents.topics[0].name = "/a\x1b]0;owned\x07\n\xff";
  logs[0].file = "\x1b[2J.bag";
  const Document document = contents_document(logs);
  EXPECT_THAT(text_page(document), Not(HasSubstr("\x1b")));
  const auto j = nlohmann::json::parse(document.json());
  EXPECT_THAT(j["logs"][0]["topics"][0]["name"].get<std::string>(), HasSubstr("\uFFFD"));
}

}  // namespace
}  // namespace credence::internal
