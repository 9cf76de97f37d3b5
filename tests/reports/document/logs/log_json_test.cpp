#include "reports/document/logs/log_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/reports/document/synthetic_logs.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;

using OrderedJson = nlohmann::ordered_json;

OrderedJson log_data(const CheckedLogs& logs) { return OrderedJson::parse(log_json(logs)); }

TEST(LogJson, HasTheKeysOfTheFormatInTheirOrder) {
  const OrderedJson j = log_data(synthetic_logs(Defect::none));
  std::vector<std::string> keys;
  for (const auto& [key, value] : j.items()) keys.push_back(key);
  EXPECT_THAT(keys, ElementsAre("schema", "files", "rows", "rejected_rows", "rejected", "wrongly_certain",
                                "unmatched_rows", "format", "remarks", "poses", "calibration", "runs",
                                "steps", "step_stride", "state_dim", "complete", "verdict", "word", "nees",
                                "nis", "blocks", "responsible_block", "sensors", "nis_fit", "single_run",
                                "covariance", "rmse", "battery", "outcomes", "null_reason"));
}

TEST(LogJson, HasTheNumbersOfTheJudgement) {
  const CheckedLogs logs = synthetic_logs(Defect::measurement_noise_too_small);
  const Judgement& judgement = logs.analysis.judgement;
  const OrderedJson j = log_data(logs);
  EXPECT_EQ(j["files"], 32);
  EXPECT_EQ(j["runs"], 32);
  EXPECT_EQ(j["steps"], 40);
  EXPECT_EQ(j["rows"], 32 * 40);
  EXPECT_EQ(j["state_dim"], 2);
  EXPECT_EQ(j["complete"], true);
  EXPECT_EQ(j["verdict"], "optimistic");
  EXPECT_EQ(j["nees"]["mean"].get<double>(), judgement.nees.mean);
  EXPECT_EQ(j["nis"]["mean"].get<double>(), judgement.nis.mean);
  EXPECT_EQ(j["covariance"]["trace"].size(), 40U);
  EXPECT_TRUE(j["covariance"]["trace_prior"].is_null()) << "a log cannot know it";
  ASSERT_EQ(j["blocks"].size(), judgement.blocks.size());
  for (const BlockVerdict& block : judgement.blocks) {
    EXPECT_EQ(j["blocks"][block.name]["mean"].get<double>(), block.verdict.mean) << block.name;
  }
  EXPECT_EQ(j["battery"]["tests"].size(), judgement.tests.size());
  EXPECT_TRUE(j["single_run"].is_null());
  EXPECT_FALSE(j.contains("sensitivity")) << "was not asked for";
  EXPECT_FALSE(j.contains("baseline"));
  EXPECT_EQ(j["calibration"]["units"], logs.calibration.units);
}

TEST(LogJson, EverySensorHasItsTests) {
  const CheckedLogs logs = synthetic_logs(Defect::shared_prior);
  const OrderedJson sensors = log_data(logs)["sensors"];
  ASSERT_EQ(sensors.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const SensorJudgement& judged = logs.analysis.judgement.sensors[i];
    EXPECT_EQ(sensors[i]["name"], judged.name);
    EXPECT_EQ(sensors[i]["nis"]["mean"].get<double>(), judged.nis.mean);
    EXPECT_EQ(sensors[i]["fit"]["values"], judged.fit.count);
    EXPECT_EQ(sensors[i]["whiteness"]["p_value"].get<double>(), judged.whiteness.p_value);
    EXPECT_EQ(sensors[i]["whiteness"]["white"], judged.whiteness.white);
    EXPECT_EQ(sensors[i]["whiteness"]["autocorrelation"].size(), judged.whiteness.autocorrelation.size());
    ASSERT_EQ(sensors[i]["dimensions"].size(), 1U) << "each is one number";
    EXPECT_EQ(sensors[i]["dimensions"][0]["dimension"], 1);
    EXPECT_EQ(sensors[i]["dimensions"][0]["count"], 32 * 40);
  }
}

TEST(LogJson, WhatWasNotTestedIsNullWithAReason) {
  CheckedLogs logs = synthetic_logs(Defect::none);
  SensorJudgement& sensor = logs.analysis.judgement.sensors.front();
  sensor.whiteness = {.p_value = std::nan(""), .white = true, .reason = "too few values"};
  sensor.fit = {.kolmogorov_p_value = std::nan(""), .anderson_p_value = std::nan(""), .reason = "no law"};
  logs.analysis.judgement.responsible.index = -1;
  const OrderedJson j = log_data(logs);
  EXPECT_TRUE(j["sensors"][0]["whiteness"]["white"].is_null()) << "not tested is not white";
  EXPECT_TRUE(j["sensors"][0]["whiteness"]["p_value"].is_null());
  EXPECT_EQ(j["sensors"][0]["whiteness"]["reason"], "too few values");
  EXPECT_EQ(j["sensors"][0]["fit"]["reason"], "no law");
  EXPECT_EQ(j["nis_fit"], j["sensors"][0]["fit"]);
  EXPECT_TRUE(j["responsible_block"].is_null());

  const OrderedJson empty = log_data({});
  EXPECT_EQ(empty["nis_fit"]["reason"], "no innovations");
  EXPECT_TRUE(empty["nis_fit"]["kolmogorov_p_value"].is_null());
  EXPECT_TRUE(empty["nis_fit"]["anderson_p_value"].is_null());
  EXPECT_TRUE(empty["calibration"].is_null());
  EXPECT_EQ(empty["poses"], OrderedJson::array());
  EXPECT_EQ(empty["blocks"], OrderedJson::object());
  EXPECT_EQ(empty["verdict"], "undecided");
}

TEST(LogJson, TheResponsibleBlockIsNamed) {
  CheckedLogs logs = synthetic_logs(Defect::none);
  ASSERT_EQ(logs.analysis.judgement.blocks.size(), 2U);
  logs.analysis.judgement.responsible.index = 1;
  EXPECT_EQ(log_data(logs)["responsible_block"], logs.analysis.judgement.blocks[1].name);
}

TEST(LogJson, RowsThatWereRejectedAndRunsThatFailedAreSaid) {
  CheckedLogs logs;
  logs.unmatched_rows = 4;
  logs.remarks = {"a column was left out"};
  Evidence& evidence = logs.analysis.evidence;
  evidence.rejected["P is not symmetric"] = {.count = 3, .first = "a.csv:7"};
  evidence.rejected["a NaN"] = {.count = 2, .first = "b.csv:1"};
  evidence.wrongly_certain["z"] = {.count = 4, .first = "a.csv:2"};
  evidence.study.runs = 5;
  evidence.study.failures = {{.run = 1, .step = 9, .outcome = Outcome::diverged},
                             {.run = 4, .step = 2, .outcome = Outcome::threw}};
  logs.failures_said[4] = "singular";
  const OrderedJson j = log_data(logs);
  EXPECT_EQ(j["rejected_rows"], 5);
  EXPECT_EQ(j["rejected"][0].dump(), R"({"reason":"P is not symmetric","count":3,"first":"a.csv:7"})");
  EXPECT_EQ(j["rejected"].size(), 2U);
  EXPECT_EQ(j["wrongly_certain"].dump(), R"([{"state":"z","count":4,"first":"a.csv:2"}])");
  EXPECT_EQ(j["unmatched_rows"], 4);
  EXPECT_EQ(j["remarks"], OrderedJson::array({"a column was left out"}));
  EXPECT_EQ(j["outcomes"]["ok"], 3);
  EXPECT_EQ(j["outcomes"]["diverged"], 1);
  EXPECT_EQ(j["outcomes"]["failures"][0].dump(), R"({"run":1,"step":9,"outcome":"diverged"})");
  EXPECT_EQ(j["outcomes"]["failures"][1]["says"], "singular");
}

TEST(LogJson, PosesHaveTheirChartsAndTheirOffset) {
  CheckedLogs logs;
  logs.poses = {synthetic_poses(), synthetic_poses()};
  logs.poses[1].time_offset->reason = "too few rows";
  logs.poses[1].time_offset->lower_s = logs.poses[1].time_offset->value_s = std::nan("");
  logs.poses.emplace_back().file = "third.csv";
  const OrderedJson poses = log_data(logs)["poses"];
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_EQ(poses[0]["file"], "folder/run.csv");
  EXPECT_EQ(poses[0]["chart"], "right");
  EXPECT_EQ(
      poses[0]["charts"][0].dump(),
      R"({"chart":"left","mean_nees_if_written_so":9.5,"p_value":0.0001,"mean_nees_carried_over":6.25})");
  EXPECT_TRUE(poses[0]["charts"][1]["p_value"].is_null());
  EXPECT_EQ(poses[0]["time_offset"]["seconds"], 0.5);
  EXPECT_EQ(poses[0]["time_offset"]["used"], true);
  EXPECT_EQ(poses[0]["time_offset"]["files"], 1);
  EXPECT_EQ(poses[1]["time_offset"]["used"], false);
  EXPECT_EQ(poses[1]["time_offset"]["reason"], "too few rows");
  EXPECT_TRUE(poses[1]["time_offset"]["lower"].is_null());
  EXPECT_TRUE(poses[2]["time_offset"].is_null());
}

TEST(LogJson, AnEarlierVersionAndASingleRunHaveKeysOfTheirOwn) {
  CheckedLogs logs;
  logs.gate = LogGate{.baseline = "old.json", .verdict_before = "consistent", .worse = {"it is worse"}};
  SingleRunJudgement single;
  single.sample.correlation_time = 2.5;
  single.sample.size = 40.0;
  single.time_average.p_value = 0.25;
  logs.analysis.judgement.single = single;
  logs.analysis.judgement.settle_nees.runs = 17;
  logs.analysis.judgement.sensitivity = SensitivityJudgement{.nees_outliers = 3, .nis_outliers = 1};
  const OrderedJson j = log_data(logs);
  EXPECT_EQ(j["baseline"]["file"], "old.json");
  EXPECT_EQ(j["baseline"]["worse"][0], "it is worse");
  EXPECT_EQ(j["single_run"]["correlation_time_rows"], 2.5);
  EXPECT_EQ(j["single_run"]["effective_rows"], 40.0);
  EXPECT_EQ(j["single_run"]["p_value"], 0.25);
  EXPECT_TRUE(j["single_run"]["reason"].is_null());
  EXPECT_EQ(j["single_run"]["runs_to_settle"], 17);
  EXPECT_FALSE(j["single_run"].contains("runs_to_settle_reason"));
  EXPECT_EQ(j["sensitivity"]["nees_outliers"], 3);
  EXPECT_EQ(j["sensitivity"]["nis_outliers"], 1);
}

TEST(LogJson, OfASingleRunWhatIsNotKnownHasItsReason) {
  CheckedLogs logs;
  Judgement& judgement = logs.analysis.judgement;
  judgement.single = SingleRunJudgement{};
  judgement.single->time_average.average.reason = "too short";
  judgement.single->time_average.p_value = std::nan("");
  judgement.settle_nees = {.runs = 0, .reason = "nothing deviates"};
  const OrderedJson short_one = log_data(logs)["single_run"];
  EXPECT_TRUE(short_one["runs_to_settle"].is_null()) << "0 stands for no number of runs";
  EXPECT_EQ(short_one["runs_to_settle_reason"], "nothing deviates");
  EXPECT_EQ(short_one["reason"], "too short");
  judgement.single->time_average.average.reason = {};
  EXPECT_THAT(log_data(logs)["single_run"]["reason"].get<std::string>(), testing::HasSubstr("not forgotten"));
}

TEST(LogJson, NamesThatAreNoUtf8AreStillJson) {
  CheckedLogs logs;
  logs.remarks = {"column \xff"};
  EXPECT_EQ(log_data(logs)["remarks"][0], "column \xEF\xBF\xBD");
}

}  // namespace
}  // namespace credence::internal
