#include "reports/document/study/comparison_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "core/nan.h"
#include "reports/render/write_document.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::Not;

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

ReportTable table_of(const std::vector<ComparedStudy>& studies) {
  return std::get<ReportTable>(comparison_document(studies, 0.95).brief.back());
}

TEST(Comparison, DifferencesArePairedRunByRun) {
  // Differences 0.1, 0.2, 0.3: mean 0.2, standard error 0.1/√3; of half the two dof t_{0.975}(1) = 12.706205
  // (tables).
  const auto d = paired_difference(study("b", "w", {1.1, 0.7, 1.8}), study("a", "w", {1.0, 0.5, 1.5}), 0.95);
  ASSERT_TRUE(d.has_value());
  EXPECT_NEAR(d->interval.mean, 0.2, 1e-15);
  EXPECT_NEAR(d->interval.upper - d->interval.mean, 12.706205 * 0.1 / std::sqrt(3.0), 1e-6);
  EXPECT_EQ(d->interval.count, 3);
  // t = 2 √3 with one dof, Cauchy's law.
  EXPECT_NEAR(d->p_value, 1.0 - 2.0 * std::atan(std::sqrt(12.0)) / std::numbers::pi, 1e-12);
}

TEST(Comparison, PValuesOfDifferencesAreAdjustedForTheStudies) {
  const std::vector<ComparedStudy> studies = {
      study("a", "w", {1.0, 0.5, 1.5}), study("b", "w", {1.1, 0.7, 1.8}), study("c", "v", {1.1, 0.7, 1.8}),
      study("d", "w", {1.0, 0.6, 1.4})};
  const auto all = differences_from_first(studies, 0.95);
  ASSERT_EQ(all.size(), 4U);
  EXPECT_FALSE(all[0] || all[2]) << "the first, and one of other noise";
  EXPECT_NEAR(all[1]->adjusted, 2.0 * all[1]->p_value, 1e-15);
  EXPECT_NEAR(all[3]->p_value, 1.0, 1e-12) << "0, 0.1, −0.1";
  EXPECT_NEAR(all[3]->adjusted, 1.0, 1e-12);
  const auto j = nlohmann::json::parse(comparison_document(studies, 0.95).json());
  EXPECT_EQ(j["studies"][1]["paired_difference"]["adjusted_p_value"].get<double>(), all[1]->adjusted);
  EXPECT_THAT(table_of(studies).rows[1].back().text, HasSubstr(", p = 0.358"));
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
  const std::vector<ComparedStudy> studies = {
      study("a", "w", {1.0, 0.5, 1.5}), study("b", "w", {1.1, 0.7, 1.8}), study("c", "v", {1.1, 0.7, 1.8})};
  const ReportTable table = table_of(studies);
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[0].back().text, "–");
  EXPECT_THAT(table.rows[1].back().text, HasSubstr("0.200 ("));
  EXPECT_EQ(table.rows[2].back().text, "–");
  EXPECT_EQ(table.rows[1][2].tone, CellTone::good);
  const auto j = nlohmann::json::parse(comparison_document(studies, 0.95).json());
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
  EXPECT_TRUE(std::isinf(read[0].factor.upper) && std::isnan(read[0].nis.mean));
  EXPECT_EQ(table_of(read).rows[0][5].text, "–") << "no NIS";
  EXPECT_EQ(compared_documents("two.json", R"({"studies": [)" + one + "," + one + "]}").size(), 2U);
  for (const char* wrong : {"", "[1]", "{}", "3", R"({"runs": 1, "verdict": "x"})", R"({"studies": [1]})"}) {
    EXPECT_THROW(compared_documents("wrong.json", wrong), std::invalid_argument) << wrong;
  }
}

TEST(Comparison, DocumentsThatCannotBeComparedAreRefusedByName) {
  const auto says = [](const std::string& document) {
    try {
      compared_documents("a.json", document);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  const auto with = [](const char* p_value, const char* confidence) {
    return fmt::format(R"({{"runs": 5, "verdict": "optimistic", "word": {{"p_value": {}}},
      "nees": {{"mean": 4.0, "expected": 3.0, "confidence": {}}}, "nis": null}})",
                       p_value, confidence);
  };
  EXPECT_EQ(says(with("0.25", "0.95")), "nothing");
  EXPECT_EQ(says(with("null", "null")), "nothing");
  EXPECT_EQ(says(with("-9223372036854775808", "0.95")),
            "a.json: word.p_value = -9.223372036854776e+18: must lie in [0, 1]");
  EXPECT_EQ(says(with("0.25", "1.0")), "a.json: nees.confidence = 1: must lie in (0, 1)");
  EXPECT_EQ(says(R"({"studies": [{"runs": -5, "verdict": "mixed", "nees": null, "nis": null}]})"),
            "a.json: runs = -5: must be a whole number of at least 0");
  EXPECT_EQ(says("{\n \"runs\": 5,,\n}"), "a.json:2: is no JSON, from column 12 on");
  const std::string rest = R"("runs": 5, "nees": {"mean": 4.0, "expected": 3.0}, )";
  EXPECT_EQ(says("{" + rest + R"("verdict": "bananas"})"),
            "a.json: verdict = bananas: accepted are consistent, optimistic, pessimistic, mixed, not "
            "Gaussian and undecided");
  EXPECT_EQ(says("{" + rest + R"("verdict": "mixed", "schema": 99})"),
            "a.json: schema = 99: this version of Credence reads 1");
  for (const char* kind : {R"("word": 5)", R"("nis": {"mean": "x"})", R"("nis": 3)"}) {
    EXPECT_THAT(says("{" + rest + R"("verdict": "mixed", )" + kind + "}"),
                testing::HasSubstr("a.json: is not a document of"))
        << kind;
  }
  const auto factor_of = [](const std::string& factor) {
    return R"({"runs": 5, "verdict": "mixed", "nees": {"mean": 4.0, "expected": null, "factor": )" + factor +
           R"(}, "nis": null})";
  };
  EXPECT_EQ(says(factor_of(R"({"value": 1.24, "lower": 1.3, "upper": 1.5})")),
            "a.json: nees.factor.value = 1.24: must lie in its interval, from 1.3 to 1.5");
  EXPECT_EQ(says(factor_of(R"({"value": 1.24, "lower": 1.1, "upper": 1.2})")),
            "a.json: nees.factor.value = 1.24: must lie in its interval, from 1.1 to 1.2");
  EXPECT_EQ(says(factor_of(R"({"value": 1.24, "lower": -1, "upper": 1.5})")),
            "a.json: nees.factor.lower = -1: must be at least 0");
  const ComparedStudy open = compared_documents("a.json", factor_of(R"({"value": 2, "lower": 1})")).at(0);
  EXPECT_EQ(mean_interval_text(open.factor), "2.00 (1.00 … ∞)");
  const ComparedStudy closed = compared_documents("a.json", factor_of(R"({"value": 2, "upper": 3})")).at(0);
  EXPECT_EQ(mean_interval_text(closed.factor), "–");
  for (const char* none : {R"({"schema": 1, "studies": []})", R"({"configurations": [], "points": []})"})
    EXPECT_EQ(says(none), "a.json: holds no results to compare");
}

std::vector<ComparedStudy> two_studies() {
  return {{.name = "plain",
           .verdict = "optimistic",
           .factor = {.mean = 1.5, .lower = 1.3, .upper = 1.7},
           .noise = "w",
           .nees_of_runs = {1.4, 1.5, 1.6},
           .nees_of_steps = {1.0, 1.5, 2.0}},
          {.name = "cautious",
           .verdict = "consistent",
           .factor = {.mean = 0.95, .lower = 0.9, .upper = 1.0},
           .noise = "w",
           .nees_of_runs = {0.9, 0.95, 1.0},
           .nees_of_steps = {1.0, 0.95, 0.9}}};
}

std::string page_of(const std::vector<ComparedStudy>& studies) {
  const TemporaryFolder folder;
  write_document(comparison_document(studies, 0.95), folder.path());
  return folder.read("index.html");
}

TEST(Comparison, AnswersWhoIsNotToBeTrustedAndWhoIsNearest) {
  const ReportAnswer answer = comparison_document(two_studies(), 0.95).answer;
  EXPECT_EQ(answer.text, "1 of 2 cannot be trusted: plain; nearest to right: cautious, factor on P 0.950");
  EXPECT_EQ(answer.tone, CellTone::alarm);
  std::vector<ComparedStudy> unknown = {{.name = "a", .verdict = "consistent", .factor = {.mean = kNaN}},
                                        {.name = "b", .verdict = "consistent", .factor = {.mean = kNaN}}};
  const auto answer_of_unknown = [&] { return comparison_document(unknown, 0.95).answer; };
  EXPECT_EQ(answer_of_unknown().text, "Of 2 results none is called optimistic: 2 consistent");
  EXPECT_EQ(answer_of_unknown().tone, CellTone::good);
  unknown[1].verdict = "pessimistic";
  EXPECT_EQ(answer_of_unknown().text, "Of 2 results none is called optimistic: 1 consistent, 1 pessimistic");
  EXPECT_EQ(answer_of_unknown().tone, CellTone::caution) << "nobody has called the second right";
}

// One of twelve exact filters is called wrong in half of all comparisons.
TEST(Comparison, WhoIsNotToBeTrustedIsSoAmongAllThatAreCompared) {
  std::vector<ComparedStudy> studies(
      12, {.name = "a", .verdict = "consistent", .p_value = 0.5, .factor = {.mean = kNaN}});
  studies[3].verdict = "optimistic";
  studies[3].p_value = 0.01;
  const auto answer = [&] { return comparison_document(studies, 0.95).answer.text; };
  EXPECT_EQ(answer(),
            "Of 12 results, taken together, none is called optimistic: 11 consistent, 1 optimistic");
  studies[3].p_value = 0.001;
  EXPECT_EQ(answer(), "1 of 12 cannot be trusted: a");
}

TEST(Comparison, NearestIsWhoseFactorNoOtherMayCome) {
  std::vector<ComparedStudy> studies = two_studies();
  studies[0].factor = {.mean = 1.1, .lower = 1.04, .upper = 1.2};
  EXPECT_EQ(comparison_document(studies, 0.95).answer.text, "1 of 2 cannot be trusted: plain");
  studies[0].factor = {.mean = 1.1, .lower = 1.06, .upper = 1.15};
  EXPECT_EQ(comparison_document(studies, 0.95).answer.text, "1 of 2 cannot be trusted: plain")
      << "that of the nearest is not known either";
}

TEST(Comparison, NearestIsOneOfSeveralAndNotOneThatCannotBeTrustedBesideOthers) {
  std::vector<ComparedStudy> studies = two_studies();
  studies[1].factor = {.mean = 0.48, .lower = 0.455, .upper = 0.504};
  studies[1].verdict = "pessimistic";
  const auto answer = [&] { return comparison_document(studies, 0.95).answer.text; };
  EXPECT_EQ(answer(), "1 of 2 cannot be trusted: plain");
  studies[1].verdict = "optimistic";
  EXPECT_EQ(answer(), "2 of 2 cannot be trusted: plain, cautious; nearest to right: plain, factor on P 1.50");
  studies[1].factor = {.mean = kNaN};
  EXPECT_EQ(answer(), "2 of 2 cannot be trusted: plain, cautious") << "there is no other to be nearer than";
}

TEST(Comparison, ThePoseHasAColumnWhereThereIsOne) {
  std::vector<ComparedStudy> studies = two_studies();
  const auto titles = [&] {
    std::vector<std::string> all;
    for (const TableColumn& column : table_of(studies).columns) all.push_back(column.title);
    return all;
  };
  EXPECT_THAT(titles(), Not(testing::Contains("of the pose")));
  studies[1].pose = ComparedMean{3.5, 3.0};
  EXPECT_THAT(titles(), testing::Contains("of the pose"));
  EXPECT_EQ(table_of(studies).rows[0][5].text, "–");
  EXPECT_EQ(table_of(studies).rows[1][5].text, "3.500 of 3.000");
}

// Two logs against the first, one part each: both are twice as improbable as alone.
TEST(Comparison, ChangesOfFactorsAreAdjustedForAllLogs) {
  const auto log = [](const std::string& name, std::vector<double> factors) {
    return ComparedStudy{.name = name,
                         .verdict = "consistent",
                         .units = {"runs", {"1", "2", "3", "4"}, {"NEES"}, {std::move(factors)}}};
  };
  const auto changes = [&](const std::vector<ComparedStudy>& logs) {
    const auto j = nlohmann::json::parse(comparison_document(logs, 0.95).json());
    std::vector<double> adjusted;
    for (std::size_t i = 1; i < logs.size(); ++i)
      adjusted.push_back(j["studies"][i]["changes"].at(0)["adjusted_p_value"].get<double>());
    return adjusted;
  };
  const ComparedStudy first = log("a", {1.0, 1.0, 1.0, 1.0}), second = log("b", {1.1, 1.3, 1.2, 1.5}),
                      third = log("c", {1.2, 1.1, 1.4, 1.3});
  const double of_second = changes({first, second})[0], of_third = changes({first, third})[0];
  const std::vector<double> both = changes({first, second, third});
  EXPECT_NEAR(std::min(both[0], both[1]), 2.0 * std::min(of_second, of_third), 1e-15);
  EXPECT_GE(both[0], of_second);
  EXPECT_GE(both[1], of_third);
}

// A step of 0.1 s beside one of 0.5 s, or beside one of no time.
TEST(Comparison, CurvesAreOverTimeWhereAllStudiesTellIt) {
  std::vector<ComparedStudy> studies = two_studies();
  const auto curves = [&] {
    const Document document = comparison_document(studies, 0.95);
    for (const DocumentPart& part : document.parts()) {
      if (const auto* figure = std::get_if<part::DrawnFigure>(&part)) return figure->make().panels.at(0);
    }
    return Panel{};
  };
  studies[0].times = StepTimes::every(0.1);
  EXPECT_EQ(curves().x_label.text, "step");
  EXPECT_EQ(curves().series.at(1).x, (FigureData{1.0, 2.0, 3.0}));
  studies[1].times = StepTimes::every(0.5);
  EXPECT_EQ(curves().x_label.text, "time (s)");
  EXPECT_EQ(curves().series.at(2).x, (FigureData{0.5, 1.0, 1.5}));
}

TEST(Comparison, ThePageHasTheTableAndTheCurvesThatAreKnown) {
  const std::string page = page_of(two_studies());
  for (const char* part :
       {"1 of 2 cannot be trusted", "id=\"figure-comparison\"", "Against the first", "NEES"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
  std::vector<ComparedStudy> documents = two_studies();
  for (ComparedStudy& study : documents) {
    study.nees_of_runs.clear();
    study.nees_of_steps.clear();
  }
  EXPECT_THAT(page_of(documents), Not(HasSubstr("figure-comparison")));
}

}  // namespace
}  // namespace credence::internal
