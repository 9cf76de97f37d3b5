#include "reports/document/tuning/replay_tune_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "core/nan.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

/// Innovations whose tests give these p-values: mean NIS, law, whiteness, mean.
InnovationTests tests_with(Verdict nis, double mean_nis, const std::vector<double>& p_values) {
  InnovationTests tests;
  tests.nis.verdict = nis;
  tests.nis.mean = mean_nis;
  tests.nis.expected = 2.0;
  tests.adjusted_p_value = p_values;
  tests.noise_scale = {.scale = 0.5 * mean_nis, .lower = kNaN, .upper = kNaN};
  return tests;
}

ReplayTuning tuned_logs() {
  ReplayTuning t;
  t.name = "2 logs";
  t.tuning.confidence = 0.95;
  t.tuning.parameters = {{.name = "noise.range_std",
                          .before = 0.1,
                          .value = 0.2,
                          .lower = 0.15,
                          .upper = 0.25,
                          .identifiable = true},
                         {.name = "noise.speed_std", .before = 0.3, .reason = "it has no effect"}};
  t.tuning.coordinates = {"noise.range_std"};
  t.tuning.notes = {"A note."};
  t.parts_are_logs = true;
  t.left_out = {{.name = "robot 1",
                 .values = {0.19},
                 .observations = 300,
                 .nis_before = 5.0,
                 .nis_after = 2.1,
                 .score_before = -4.0,
                 .score_after = -1.0},
                {.name = "robot 2",
                 .values = {0.21},
                 .observations = 200,
                 .nis_before = 6.0,
                 .nis_after = 1.9,
                 .score_before = -5.0,
                 .score_after = -2.0}};
  t.before = tests_with(Verdict::optimistic, 5.4, {1e-9, 1e-9, 0.5, 1.0});
  t.after = tests_with(Verdict::consistent, 2.02, {0.8, 0.9, 1.0, 1.0});
  return t;
}

/// The document of a tuning, whose figure is not asked for: it would replay the log.
Document shown_tuning(const ReplayTuning& tuning) {
  static const std::vector<ReplayedLog> logs = {{"log", {}, [](const ReplaySettings&) {
                                                   ReplayResult result;
                                                   result.records.resize(100);
                                                   result.updated = 100;
                                                   for (ReplayObservation& o : result.records)
                                                     o.whitened.setOnes();
                                                   return result;
                                                 }}};
  static const ReplayScore score(logs, {"noise.range_std"}, 1);
  return replay_tune_document(tuning, score);
}

TEST(ReplayTuneReport, TheVerdictOnWhatWasLeftOutIsThatOfTheMeanElseMixed) {
  ReplayTuning t = tuned_logs();
  EXPECT_EQ(left_out_verdict(t), Verdict::consistent);
  t.after = tests_with(Verdict::pessimistic, 1.5, {0.001, 0.001, 1.0, 1.0});
  EXPECT_EQ(left_out_verdict(t), Verdict::pessimistic);
  t.after = tests_with(Verdict::consistent, 2.0, {0.5, 1.0, 0.05, 1.0});
  EXPECT_EQ(left_out_verdict(t), Verdict::mixed) << "p ≤ 1 − confidence";
  t.after = tests_with(Verdict::consistent, 2.0, {0.5, kNaN, 0.051, kNaN});
  EXPECT_EQ(left_out_verdict(t), Verdict::consistent) << "what is not tested rejects nothing";
}

TEST(ReplayTuneReport, TheAnswerIsOfWhatWasLeftOut) {
  const ReportAnswer answer = shown_tuning(tuned_logs()).answer;
  EXPECT_EQ(answer.text,
            "The data of 2 logs ask for noise.range_std = 0.2000 (0.1500 … 0.2500); on parts that it was not "
            "tuned on the filter is consistent, mean NIS 2.02 where 2.00 is expected (5.40 before)");
  EXPECT_EQ(answer.tone, CellTone::good);
  ReplayTuning mixed = tuned_logs();
  mixed.after.adjusted_p_value[2] = 0.001;
  EXPECT_THAT(shown_tuning(mixed).answer.text, HasSubstr("the filter is mixed"));
  EXPECT_EQ(shown_tuning(mixed).answer.tone, CellTone::caution);
}

TEST(ReplayTuneReport, ASearchThatDidNotConvergeIsInTheAnswer) {
  ReplayTuning t = tuned_logs();
  t.tuning.converged = false;
  const Document document = shown_tuning(t);
  EXPECT_THAT(document.answer.text,
              testing::StartsWith("The search did not converge, and what follows is no more than its best "
                                  "trial. The data of 2 logs ask for noise.range_std"));
  EXPECT_EQ(document.answer.tone, CellTone::caution);
  EXPECT_THAT(table_of(document, "the noise that the data ask for").notes.back(),
              testing::StartsWith("The search did not converge"));
}

TEST(ReplayTuneReport, TableAndDataHaveEveryPart) {
  const Document document = shown_tuning(tuned_logs());
  const auto j = nlohmann::json::parse(document.json());
  const ReportTable table = table_of(document, "Each log by the noise of the others");
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[1][0].text, "robot 2");
  EXPECT_EQ(table.rows[1][2].text, "6.00");
  EXPECT_EQ(table.rows[1][3].text, "1.90");
  EXPECT_EQ(table.rows[1][6].text, "0.210");
  EXPECT_EQ(table.columns[6].title, "noise.range_std (m)");
  EXPECT_EQ(table_of(document, "the noise that the data ask for").rows[0][0].text, "noise.range_std (m)");
  const auto& held = j["held_out"];
  EXPECT_EQ(held["verdict"], "consistent");
  EXPECT_EQ(held["before"]["verdict"], "optimistic");
  EXPECT_EQ(held["runs"], 2);
  EXPECT_EQ(held["parts_are"], "logs");
  EXPECT_EQ(held["law_p_value"], 0.9);
  EXPECT_EQ(held["before"]["whiteness_p_value"], 0.5);
  EXPECT_TRUE(held["noise_scale"]["lower"].is_null());
  EXPECT_EQ(held["parts"][1]["sights"], 200);
  EXPECT_EQ(held["parts"][1]["tuned_on_the_others"]["noise.range_std"], 0.21);
  EXPECT_EQ(held["parts"][1]["nis"]["before"], 6.0);
  EXPECT_EQ(held["parts"][1]["log_score"]["after"], -2.0);
  EXPECT_THAT(j["notes"].back().get<std::string>(), testing::EndsWith(": --set noise.range_std=0.2000"))
      << "and nothing of what was not found";
}

TEST(ReplayTuneReport, WhatTheGateLeavesOutIsSaid) {
  ReplayTuning t = tuned_logs();
  t.left_out_by_gate = 17;
  const auto j = nlohmann::json::parse(shown_tuning(t).json());
  EXPECT_EQ(j["left_out_by_gate"], 17);
  EXPECT_THAT(j["notes"][1].get<std::string>(),
              testing::StartsWith("17 observations that the present gate rejects"));
}

TEST(ReplayTuneReport, APartThatWasNotTunedApartIsSaid) {
  ReplayTuning t = tuned_logs();
  const auto json = [&] { return nlohmann::json::parse(shown_tuning(t).json()); };
  const auto notes = [&] { return json()["notes"].dump(); };
  EXPECT_THAT(notes(), testing::Not(HasSubstr("is no proof")));
  t.left_out[1].tuned_apart = false;
  EXPECT_EQ(json()["held_out"]["parts"][0]["tuned_apart"], true);
  EXPECT_EQ(json()["held_out"]["parts"][1]["tuned_apart"], false);
  EXPECT_THAT(notes(), HasSubstr("robot 2: the others found no better noise than that of all data"));
}

TEST(ReplayTuneReport, WhereNothingIsFoundNothingWasLeftOut) {
  ReplayTuning t = tuned_logs();
  t.tuning.coordinates.clear();
  t.tuning.parameters[0] = {.name = "noise.range_std", .before = 0.1, .reason = "it has no effect"};
  t.left_out.clear();
  t.before = t.after = {};
  const Document document = shown_tuning(t);
  EXPECT_EQ(document.answer.text, "A note");
  EXPECT_TRUE(nlohmann::json::parse(document.json())["held_out"].is_null());
  EXPECT_THROW(table_of(document, "left out"), std::out_of_range);
  EXPECT_THROW(figure_of(document, "profiles"), std::out_of_range);
}

}  // namespace
}  // namespace credence::internal
