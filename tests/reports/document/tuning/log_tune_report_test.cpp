#include "reports/document/tuning/log_tune_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "core/nan.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// S should be three times as large, and the innovations are correlated.
InnovationTuning lidar() {
  InnovationTuning t;
  t.name = "lidar";
  t.dof = 2.0;
  t.values = 900;
  t.left_out = 7;
  t.scale = {.scale = 3.0, .lower = 2.5, .upper = 3.6, .stretches = 20};
  t.steps_for_10_percent = 200.0;
  t.lag_one = 0.3;
  t.band = 0.065;
  t.whiteness_p_value = 1e-9;
  t.gain = GainError::too_small;
  t.score_before = -3.0;
  t.score_after = -2.5;
  t.likelihood_ratio_p_value = kNaN;
  t.left_out_parts = {.verdict = Verdict::mixed,
                      .parts = 9,
                      .rejected = 2,
                      .tested = true,
                      .of_runs = true,
                      .mean_nis = 2.25};
  t.notes = {"A log does not hold F and H.", "The gain is too small."};
  return t;
}

/// Nothing is wrong with it.
InnovationTuning gps() {
  InnovationTuning t;
  t.name = "gps";
  t.dof = 2.0;
  t.values = 100;
  t.scale = {.scale = 1.01, .lower = 0.9, .upper = 1.1, .stretches = 20};
  t.left_out_parts = {.verdict = Verdict::consistent, .parts = 5, .tested = true, .mean_nis = 2.0};
  t.notes = {"A log does not hold F and H."};
  return t;
}

InnovationTuning too_short() {
  InnovationTuning t = gps();
  t.name = "";
  t.scale = {.scale = 1.2, .lower = kNaN, .upper = kNaN, .stretches = 1, .reason = "too few stretches"};
  return t;
}

std::vector<std::string> cells_of(const ReportTable& table, std::size_t row) {
  std::vector<std::string> texts;
  for (const TableCell& cell : table.rows.at(row)) texts.push_back(cell.text);
  return texts;
}

TEST(LogTuneReport, TheAnswerIsOfEverySensor) {
  EXPECT_EQ(
      log_tune_document("log", {lidar(), gps()}).answer.text,
      "lidar: S should be 3.00 (2.50 … 3.60) times what it is, and the gain is too small; gps: S agrees with "
      "its innovations; most likely is 1.01 (0.900 … 1.10) times what it is");
  EXPECT_EQ(log_tune_document("log", {lidar(), gps()}).answer.tone, CellTone::caution);
  EXPECT_EQ(log_tune_document("log", {gps()}).answer.tone, CellTone::good) << "the interval holds 1";
  EXPECT_EQ(log_tune_document("log", {too_short()}).answer.text, "no factor on S can be told");
  EXPECT_EQ(log_tune_document("log", {too_short()}).answer.tone, CellTone::caution);
  EXPECT_EQ(std::get<std::string>(log_tune_document("log", {too_short()}).brief.front()),
            "no factor on S can be told.")
      << "on a terminal as well";
}

TEST(LogTuneReport, WhatComesFirstTakesThePlaceOfTheFactor) {
  InnovationTuning compass = gps();
  compass.name = "compass";
  compass.comes_first = "3 innovations of an angle lie beyond half a turn";
  compass.notes.push_back("First: 3 innovations of an angle.");
  const Document document = log_tune_document("log", {gps(), compass});
  EXPECT_THAT(document.answer.text,
              ::testing::EndsWith("; compass: 3 innovations of an angle lie beyond half a turn, which comes "
                                  "first: until then neither a factor on S nor the gain can be told"));
  EXPECT_EQ(document.answer.tone, CellTone::caution);
  EXPECT_EQ(cells_of(table_of(document, "innovations alone"), 1)[4], "not to be trusted");
  const auto j = nlohmann::json::parse(document.json());
  EXPECT_EQ(j["sensors"][1]["comes_first"], compass.comes_first);
  EXPECT_TRUE(j["sensors"][0]["comes_first"].is_null());
  EXPECT_EQ(j["notes"].front(), "compass: First: 3 innovations of an angle.");
  EXPECT_THAT(j["notes"].back().get<std::string>(), HasSubstr("reaches the others' innovations"));
}

TEST(LogTuneReport, TheTableHasARowForEachSensor) {
  const ReportTable table = table_of(log_tune_document("log", {lidar(), too_short()}), "innovations alone");
  EXPECT_THAT(cells_of(table, 0),
              ElementsAre("lidar", "900", "3.00 (2.50 … 3.60)", "0.30 (white: within ±0.065)", "too small",
                          "2 of 9 runs rejected"));
  EXPECT_THAT(cells_of(table, 1),
              ElementsAre("–", "100", "not identifiable", "–", "none seen", "0 of 5 stretches rejected"));
}

TEST(LogTuneReport, OfOneSensorTheDocumentHasTheMembersOfAScenarios) {
  const auto j = nlohmann::json::parse(log_tune_document("log", {lidar()}).json());
  EXPECT_EQ(j["parameters"][0]["name"], "factor on S of lidar");
  EXPECT_EQ(j["parameters"][0]["value"], 3.0);
  EXPECT_EQ(j["parameters"][0]["before"], 1.0);
  EXPECT_EQ(j["log_score"], j["sensors"][0]["log_score"]);
  EXPECT_EQ(j["log_score"]["before"], -3.0);
  EXPECT_TRUE(j["log_score"]["likelihood_ratio_p_value"].is_null());
  EXPECT_EQ(j["held_out"], j["sensors"][0]["held_out"]);
  EXPECT_EQ(j["held_out"]["runs"], 9);
  EXPECT_EQ(j["held_out"]["rejected"], 2);
  EXPECT_EQ(j["held_out"]["parts_are"], "runs");
  EXPECT_EQ(j["held_out"]["nis"]["mean"], 2.25);
  EXPECT_EQ(j["sensors"][0]["left_out"], 7);
  EXPECT_EQ(j["sensors"][0]["lag_one_correlation"], 0.3);
  EXPECT_EQ(j["sensors"][0]["gain"], "too small");
}

TEST(LogTuneReport, OfSeveralSensorsEachHasItsOwn) {
  const auto j = nlohmann::json::parse(log_tune_document("log", {lidar(), too_short()}).json());
  EXPECT_TRUE(j["log_score"].is_null());
  EXPECT_TRUE(j["held_out"].is_null());
  ASSERT_EQ(j["parameters"].size(), 2U);
  EXPECT_EQ(j["parameters"][1]["name"], "factor on S");
  for (const char* number : {"value", "lower", "upper"})
    EXPECT_TRUE(j["parameters"][1][number].is_null()) << number;
  EXPECT_EQ(j["parameters"][1]["null_reason"], "too few stretches");
  EXPECT_EQ(j["parameters"][1]["identifiable"], false);
  EXPECT_FALSE(j["parameters"][0].contains("null_reason"));
}

TEST(LogTuneReport, WhatHoldsForEveryLogIsSaidOnceAndTheRestWithItsSensor) {
  InnovationTuning second = lidar();
  second.name = "radar";
  const auto j = nlohmann::json::parse(log_tune_document("log", {lidar(), second}).json());
  EXPECT_THAT(j["notes"].get<std::vector<std::string>>(),
              ElementsAre("A log does not hold F and H.", "lidar: The gain is too small.",
                          "radar: The gain is too small."));
  const auto one = nlohmann::json::parse(log_tune_document("log", {lidar()}).json());
  EXPECT_EQ(one["notes"][1], "The gain is too small.");
}

}  // namespace
}  // namespace credence::internal
