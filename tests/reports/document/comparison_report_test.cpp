#include "reports/document/comparison_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace credence {
namespace {

using testing::HasSubstr;

ComparedStudy study(const std::string& name, const std::string& noise, std::vector<double> runs) {
  return {.name = name,
          .runs = static_cast<std::int64_t>(runs.size()),
          .verdict = "consistent",
          .factor = {.mean = 1.0, .lower = 0.9, .upper = 1.1},
          .nees = {3.0, 3.0},
          .nis = {2.0, 2.0},
          .noise = noise,
          .nees_of_runs = std::move(runs)};
}

TEST(Comparison, DifferencesArePairedRunByRun) {
  // Differences 0.1, 0.2, 0.3: mean 0.2, standard error 0.1/√3; t_{0.975}(2) = 4.302653 (tables).
  const auto d = paired_difference(study("b", "w", {1.1, 0.7, 1.8}), study("a", "w", {1.0, 0.5, 1.5}), 0.95);
  ASSERT_TRUE(d.has_value());
  EXPECT_NEAR(d->mean, 0.2, 1e-15);
  EXPECT_NEAR(d->upper - d->mean, 4.302653 * 0.1 / std::sqrt(3.0), 1e-6);
  EXPECT_EQ(d->count, 3);
}

TEST(Comparison, RunsOfOtherNoiseOrOfUnknownNoiseAreNotPaired) {
  const ComparedStudy a = study("a", "w", {1.0, 0.5, 1.5});
  EXPECT_EQ(paired_difference(study("b", "other", {1.0, 0.5, 1.5}), a, 0.95), std::nullopt);
  EXPECT_EQ(paired_difference(study("b", "", {1.0, 0.5}), study("a", "", {1.0, 0.5}), 0.95), std::nullopt);
  EXPECT_EQ(paired_difference(study("b", "w", {1.0}), a, 0.95), std::nullopt);
  EXPECT_TRUE(paired_difference(study("b", "w", {1.0, 0.4}), a, 0.95).has_value())
      << "of the runs that both have";
}

TEST(Comparison, TheTableSaysWhatTheDocumentSays) {
  const ComparedStudy studies[] = {study("a", "w", {1.0, 0.5, 1.5}), study("b", "w", {1.1, 0.7, 1.8}),
                                   study("c", "v", {1.1, 0.7, 1.8})};
  const ReportTable table = comparison_table(studies, 0.95);
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[0].back().text, "–");
  EXPECT_THAT(table.rows[1].back().text, HasSubstr("0.200 ("));
  EXPECT_EQ(table.rows[2].back().text, "–");
  EXPECT_EQ(table.rows[1][2].tone, CellTone::good);
  const auto j = nlohmann::json::parse(comparison_json(studies, 0.95));
  EXPECT_NEAR(j["studies"][1]["paired_difference"]["value"].get<double>(), 0.2, 1e-15);
  EXPECT_TRUE(j["studies"][2]["paired_difference"].is_null());
  EXPECT_TRUE(j["studies"][0]["vehicle_nees"].is_null());
}

TEST(Comparison, DocumentsAreReadAndOthersRefused) {
  const std::string one = R"({"runs": 5, "verdict": "optimistic", "scenario": {"name": "loop"},
    "nees": {"mean": 4.0, "expected": 3.0, "factor": {"value": 1.3, "lower": 1.1, "upper": null}},
    "nis": {"mean": null, "expected": 2.0}})";
  const auto read = compared_documents("a.json", one);
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].name, "loop");
  EXPECT_EQ(read[0].nees.mean, 4.0);
  EXPECT_EQ(read[0].factor.mean, 1.3);
  EXPECT_TRUE(std::isnan(read[0].factor.upper) && std::isnan(read[0].nis.mean));
  EXPECT_EQ(comparison_table(read, 0.95).rows[0][6].text, "–") << "no NIS";
  EXPECT_EQ(compared_documents("two.json", R"({"studies": [)" + one + "," + one + "]}").size(), 2U);
  for (const char* wrong : {"", "[1]", "{}", "3", R"({"runs": 1, "verdict": "x"})", R"({"studies": [1]})"}) {
    EXPECT_THROW(compared_documents("wrong.json", wrong), std::invalid_argument) << wrong;
  }
}

}  // namespace
}  // namespace credence
