#include "reports/document/estimators/estimator_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/nan.h"
#include "montecarlo/scenario/scenario_io.h"
#include "reports/render/text_page.h"
#include "tests/paths.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::Not;

EstimatorStudy study_of(const char* name) {
  const std::vector<std::string> small = {"study.runs=40", "study.steps=20"};
  return study_estimators(load_scenario(source_folder() / "scenarios" / (std::string(name) + ".toml"), small),
                          {});
}

// Any states have neither headings nor metres.
TEST(EstimatorDocument, OfALinearWorldSpeaksOfTheState) {
  const EstimatorStudy study = study_of("linear_estimators");
  const Document document = estimator_document(study);
  const std::string text = text_page(document);
  for (const char* word : {"heading", "position", "pose", "odometry", "°", "m²"}) {
    EXPECT_THAT(text, Not(HasSubstr(word)));
  }
  EXPECT_THAT(text, HasSubstr("the state of any"));
  const auto j = nlohmann::json::parse(estimator_json(study));
  EXPECT_TRUE(j["bound"]["heading_rad"].is_null());
  EXPECT_TRUE(j["bound"]["position_m"].is_null());
  EXPECT_GT(j["bound"]["state"], 0.0);
  const auto& row = j["rows"][0];
  for (const char* part : {"rmse", "claimed_rmse"}) {
    EXPECT_TRUE(row[part]["heading_rad"].is_null()) << part;
    EXPECT_TRUE(row[part]["position_m"].is_null()) << part;
    EXPECT_GT(row[part]["state"], 0.0) << part;
  }
  EXPECT_GT(row["efficiency"]["state"]["mean"], 0.0);
  EXPECT_TRUE(row["efficiency"]["position"]["mean"].is_null());
  EXPECT_TRUE(row["efficiency"]["position"]["lower"].is_null());
  EXPECT_EQ(row["rmse"]["position_interval_m"].dump(), "[null,null]");
}

TEST(EstimatorDocument, WhereNoRunEndsWellNothingIsGood) {
  EstimatorStudy study = study_of("linear_estimators");
  for (EstimatorRow& row : study.rows) row.runs = 0;
  EXPECT_EQ(estimator_document(study).answer.text, "No run of any estimator finished");
}

TEST(EstimatorDocument, OfAVehicleSpeaksOfHeadingAndMetres) {
  const EstimatorStudy study = study_of("huang_ring");
  const Document document = estimator_document(study);
  const std::string text = text_page(document);
  for (const char* word : {"NEES of heading", "RMSE heading °", "position m"}) {
    EXPECT_THAT(text, HasSubstr(word));
  }
  // Colours are of what is judged.
  for (const auto& part : document.brief) {
    const auto* table = std::get_if<ReportTable>(&part);
    if (table == nullptr) continue;
    for (std::size_t c = 0; c < table->columns.size(); ++c) {
      const std::string& title = table->columns[c].title;
      if (title != "NEES of heading" && title != "of position") continue;
      for (const auto& row : table->rows) EXPECT_EQ(row[c].tone, CellTone::plain) << title;
    }
  }
  const auto j = nlohmann::json::parse(estimator_json(study));
  EXPECT_GT(j["rows"][0]["rmse"]["position_m"], 0.0);
  EXPECT_TRUE(j["rows"][0]["rmse"]["state"].is_null());
}

EstimatorRow estimator_row(const std::string& name, double mean, double lower, DirectedPValues p = {},
                           std::int64_t runs = 20) {
  EstimatorRow row;
  row.name = name;
  row.runs = runs;
  row.profile.chart = "plane";
  row.nees[static_cast<std::size_t>(EstimatorBlock::pose)] = {
      .mean = mean, .lower = lower, .upper = 2.0 * mean, .count = runs};
  row.p_values[static_cast<std::size_t>(EstimatorBlock::pose)] = p;
  return row;
}

ReportAnswer answer_of(std::vector<EstimatorRow> rows) {
  EstimatorStudy study;
  study.scenario = load_scenario_text("[world]\nmodel = \"planar_slam\"\n", "world.toml");
  study.rows = std::move(rows);
  study.runs = 20;
  return estimator_document(study).answer;
}

TEST(EstimatorDocument, EveryEstimatorIsInTheAnswer) {
  const EstimatorRow good = estimator_row("fej", 1.0, 0.9),
                     bad = estimator_row("ekf", 3.25, 3.0, {0.01, 1.0}),
                     wasteful = estimator_row("schmidt", 0.125, 0.1, {1.0, 0.01}),
                     none = estimator_row("ukf", kNaN, kNaN, {kNaN, kNaN}, 0);
  EXPECT_EQ(answer_of({good}).text, "No evidence against the pose of any: fej");
  EXPECT_EQ(answer_of({good}).tone, CellTone::good);
  EXPECT_EQ(
      answer_of({bad, good}).text,
      "Optimistic in the pose: ekf (3.25 times the squared error that P claims). No evidence against fej");
  EXPECT_EQ(answer_of({bad}).text,
            "Optimistic in the pose: ekf (3.25 times the squared error that P claims). None is consistent");
  EXPECT_EQ(answer_of({bad}).tone, CellTone::caution);
  EXPECT_EQ(answer_of({good, none}).text,
            "No evidence against the pose of any: fej. Nothing can be said of ukf");
  EXPECT_EQ(answer_of({good, none}).tone, CellTone::caution);
  EXPECT_EQ(answer_of({wasteful, good}).text,
            "Pessimistic in the pose: schmidt (0.125 times the squared error that P claims). No evidence "
            "against fej");
  EXPECT_EQ(answer_of({wasteful}).tone, CellTone::caution);
  const EstimatorRow one_of_many = estimator_row("ukf", 1.1, 1.01, {0.2, 1.0});  // of its own interval 0.02
  EXPECT_EQ(answer_of({one_of_many, good}).text,
            "No evidence against fej. Inconsistent alone, but not among so many: ukf");
  EXPECT_EQ(answer_of({one_of_many}).text,
            "Inconsistent alone, but not with all its tests taken together: ukf");
  EstimatorRow failing = good;
  failing.failures.push_back({3, 7, Outcome::diverged});
  EXPECT_EQ(answer_of({failing}).text,
            "No evidence against the pose of any: fej. Failed: 1 of 20 runs of fej");
  EXPECT_EQ(answer_of({failing}).tone, CellTone::caution);
  EstimatorRow of_map = good;
  of_map.nees[static_cast<std::size_t>(EstimatorBlock::map)] = {
      .mean = 1.35, .lower = 1.16, .upper = 1.63, .count = 20};
  DirectedPValues& p = of_map.p_values[static_cast<std::size_t>(EstimatorBlock::map)];
  p.optimistic = 0.01;
  EXPECT_EQ(answer_of({of_map}).text,
            "No evidence against the pose of any: fej. The map is optimistic, though not the pose: fej "
            "(1.35 times)");
  EXPECT_EQ(answer_of({of_map}).tone, CellTone::caution);
  p = {1.0, 0.01};
  EXPECT_THAT(answer_of({of_map}).text, HasSubstr("The map is pessimistic, though not the pose: fej"));
  EstimatorRow wide = good;
  wide.name = "ukf";
  wide.nees[static_cast<std::size_t>(EstimatorBlock::pose)].upper = 2.01;
  EXPECT_EQ(answer_of({wide}).text,
            "Undecided after 20 runs, as its squared error may be twice what P claims: ukf");
  EXPECT_EQ(answer_of({wide}).tone, CellTone::caution);
  EXPECT_EQ(answer_of({good, wide}).text,
            "No evidence against fej. Undecided after 20 runs, as its squared error may be twice what P "
            "claims: ukf");
  EstimatorRow deep = wide;
  deep.nees[static_cast<std::size_t>(EstimatorBlock::pose)] = {
      .mean = 0.9, .lower = 0.49, .upper = 1.5, .count = 20};
  EXPECT_THAT(answer_of({deep, wide}).text,
              HasSubstr("as their squared error may be twice what P claims, or half: "));
  EXPECT_THAT(answer_of({deep}).text, HasSubstr("as its squared error may be half of what P claims: "));
  EXPECT_EQ(answer_of({none}).text, "No run of any estimator finished");
  EXPECT_EQ(answer_of({none}).tone, CellTone::alarm);
}

TEST(EstimatorDocument, NotesAreOfOneRunAndOfAnyWorld) {
  EstimatorStudy study;
  study.scenario = load_scenario_text("[world]\nmodel = \"spatial_slam\"\n", "world.toml");
  study.runs = 20;
  EstimatorRow row = estimator_row("invariant", 1.0, 0.9);
  row.profile.chart = "group";
  row.profile.chart_text = "log(X X̂⁻¹)";
  row.failures.push_back({3, 7, Outcome::diverged});
  study.rows = {row};
  const std::string text = text_page(estimator_document(study));
  EXPECT_THAT(text, Not(HasSubstr("In the plane")));
  EXPECT_THAT(text, HasSubstr("invariant: its chart is log(X X̂⁻¹). Taken as x̂ − x its pose NEES is"));
  EXPECT_THAT(text,
              HasSubstr("invariant: 1 of 20 runs failed and is in no average: 3 (diverged at step 7)."));
}

// Of three runs a gain of 2963648 was shown.
TEST(EstimatorDocument, AGainBeyondItsOrderIsNotWrittenOut) {
  EstimatorStudy study;
  study.scenario = load_scenario_text("[world]\nmodel = \"planar_slam\"\n", "world.toml");
  study.runs = 20;
  study.rows = {estimator_row("ideal", 1.0, 0.9), estimator_row("ekf", 1.0, 0.9)};
  PairedDifference paired;
  paired.first = "ekf";
  paired.second = "ideal";
  paired.gain = 2963648.0;
  study.paired = {paired};
  EXPECT_THAT(text_page(estimator_document(study)), HasSubstr("> 10000"));
  study.paired[0].gain = 252.0;
  EXPECT_THAT(text_page(estimator_document(study)), Not(HasSubstr("> 10000")));
}

}  // namespace
}  // namespace credence::internal
