#include "reports/document/logs/log_gate.h"

#include <gmock/gmock.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/nan.h"
#include "reports/document/study/calibration_report.h"
#include "reports/document/study/judgement_json.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::ThrowsMessage;

/// What units with these factors on P are in a log.
UnitFactors factors_of(const std::vector<std::pair<std::string, double>>& units) {
  UnitFactors all{.units = "runs", .names = {}, .parts = {"NEES"}, .factors = {{}}};
  for (const auto& [name, factor] : units) {
    all.names.push_back(name);
    all.factors[0].push_back(factor);
  }
  return all;
}

CheckedLogs checked(const UnitFactors& units, Verdict verdict = Verdict::optimistic,
                    double confidence = 0.95) {
  CheckedLogs logs;
  logs.name = "logs";
  logs.units = units;
  logs.analysis.evidence.has_truth = true;
  logs.analysis.judgement.confidence = confidence;
  logs.analysis.judgement.word.verdict = verdict;
  return logs;
}

/// The document of an earlier check with these factors.
std::string baseline_of(const UnitFactors& units, const std::string& verdict = "optimistic") {
  Calibration calibration;
  calibration.units = units.units;
  return text_of_json({{"verdict", verdict},
                       {"nees", Json::object()},
                       {"unmatched_rows", 0},
                       {"calibration", calibration_json(calibration, units, {})}});
}

constexpr double kMargin = 0.1;

/// Eight runs, right and twice as large.
const std::vector<std::pair<std::string, double>> kRightRuns = {
    {"a", 1.0}, {"b", 1.1}, {"c", 0.9}, {"d", 1.0}, {"e", 0.8}, {"f", 1.2}, {"g", 1.0}, {"h", 1.0}};
const std::vector<std::pair<std::string, double>> kWrongRuns = {
    {"a", 2.0}, {"b", 2.3}, {"c", 1.7}, {"d", 2.1}, {"e", 1.8}, {"f", 2.2}, {"g", 1.9}, {"h", 2.1}};

std::vector<std::pair<std::string, double>> with(std::vector<std::pair<std::string, double>> runs,
                                                 const std::vector<std::pair<std::string, double>>& more) {
  runs.insert(runs.end(), more.begin(), more.end());
  return runs;
}

LogGate gate_of(const UnitFactors& before, const UnitFactors& now) {
  return gate_against(checked(now), "before.json", baseline_of(before), kMargin);
}

TEST(LogGate, AFactorThatMovesAwayFromOneIsWorseAndOneThatComesNearerIsNot) {
  const UnitFactors right = factors_of(kRightRuns), wrong = factors_of(kWrongRuns);
  ASSERT_THAT(gate_of(right, wrong).worse, SizeIs(1));
  EXPECT_THAT(gate_of(right, wrong).worse.front(), HasSubstr("more optimistic in the whole state"));
  EXPECT_THAT(gate_of(wrong, right).worse, IsEmpty());
  EXPECT_THAT(gate_of(right, right).worse, IsEmpty());
}

TEST(LogGate, OnlyUnitsThatBothLoggedSayWhichFactorIsNearerToOne) {
  // The logs that are no longer there were far off: the others are twice as wrong as they were.
  const UnitFactors before = factors_of(with(kRightRuns, {{"gone", 9.0}, {"gone too", 12.0}}));
  const UnitFactors now = factors_of(with(kWrongRuns, {{"new", 0.001}}));
  const LogGate gate = gate_of(before, now);
  ASSERT_THAT(gate.changes, SizeIs(1));
  EXPECT_DOUBLE_EQ(gate.changes[0].before, 1.0);
  EXPECT_DOUBLE_EQ(gate.changes[0].after, 16.1 / 8.0);
  EXPECT_THAT(gate.worse, SizeIs(1));
}

TEST(LogGate, AUnitWithoutAFactorDoesNotBlindIt) {
  const UnitFactors before = factors_of(with(kRightRuns, {{"singular", HUGE_VAL}}));
  const UnitFactors now = factors_of(with(kWrongRuns, {{"singular", 1.0}}));
  EXPECT_THAT(gate_of(before, now).worse, SizeIs(1));
}

TEST(LogGate, ASmallChangeAndOneByChanceAreNotWorse) {
  const UnitFactors before = factors_of({{"a", 1.0}, {"b", 1.1}, {"c", 0.9}, {"d", 1.0}});
  EXPECT_THAT(gate_of(before, factors_of({{"a", 1.05}, {"b", 1.15}, {"c", 0.95}, {"d", 1.05}})).worse,
              IsEmpty())
      << "within the margin";
  EXPECT_THAT(gate_of(before, factors_of({{"a", 8.0}, {"b", 0.5}, {"c", 0.6}, {"d", 2.0}})).worse, IsEmpty())
      << "no two alike";
}

TEST(LogGate, WhatItSaysOfAChangeHoldsAtTheConfidenceAsked) {
  // Eight differences −0.8 ± 0.62: t = 3.4 of half of seven dof, p = 0.03.
  std::vector<std::pair<std::string, double>> runs;
  for (int i = 0; i < 8; ++i) runs.emplace_back(std::to_string(i), i % 2 == 0 ? 1.82 : 0.58);
  const UnitFactors now = factors_of(runs);
  for (auto& run : runs) run.second = 2.0;
  const UnitFactors before = factors_of(runs);
  for (const double confidence : {0.95, 0.99}) {
    const LogGate gate = gate_against(checked(now, Verdict::optimistic, confidence), "before.json",
                                      baseline_of(before), kMargin);
    ASSERT_THAT(gate.changes, SizeIs(1));
    ASSERT_GT(gate.changes[0].adjusted, 0.01);
    ASSERT_LT(gate.changes[0].adjusted, 0.05);
    if (confidence < 0.96)
      EXPECT_THAT(gate_sentence(gate), HasSubstr("It is nearer to right in the whole state"));
    if (confidence > 0.98) EXPECT_THAT(gate_sentence(gate), Not(HasSubstr("It is")));
  }
}

TEST(LogGate, AVerdictThatBecameInconsistentIsWorse) {
  const UnitFactors none = factors_of({});
  const auto gate = [&](Verdict now, const char* before) {
    return gate_against(checked(none, now), "before.json", baseline_of(none, before), kMargin);
  };
  EXPECT_TRUE(gate(Verdict::pessimistic, "consistent").became_inconsistent);
  EXPECT_TRUE(gate(Verdict::mixed, "undecided").became_inconsistent);
  EXPECT_FALSE(gate(Verdict::pessimistic, "optimistic").became_inconsistent);
  EXPECT_TRUE(gate(Verdict::optimistic, "pessimistic").became_inconsistent) << "safe is not unsafe";
  EXPECT_TRUE(gate(Verdict::mixed, "pessimistic").became_inconsistent);
  EXPECT_FALSE(gate(Verdict::mixed, "optimistic").became_inconsistent);
  EXPECT_FALSE(gate(Verdict::undecided, "consistent").became_inconsistent);
  EXPECT_EQ(
      gate_sentence(gate(Verdict::mixed, "consistent")),
      "Against before.json (consistent): WORSE: it was consistent, and is mixed. Nothing could be "
      "compared, as it has means with bounds of nothing (`nees`, `blocks` and `sensors` with `mean` and "
      "`overall`) and these logs of nothing; write it anew with `credence check --format json` of logs with "
      "the same states and innovations; the verdict counts as without a baseline.");
}

// Both factors share the error of their runs: one that seems 0.85 of 1 after a repair of 1.0 may be right.
TEST(LogGate, AChangeAcrossOneIsNotWorseByChance) {
  std::vector<std::pair<std::string, double>> before, now;
  for (int i = 0; i < 12; ++i) {
    const double of_run = 0.7 + 0.05 * i;
    before.emplace_back(std::to_string(i), 1.08 * of_run);
    now.emplace_back(std::to_string(i), 0.86 * of_run);
  }
  const LogGate gate = gate_of(factors_of(before), factors_of(now));
  ASSERT_LT(gate.changes.at(0).adjusted, 1e-3);
  EXPECT_THAT(gate.worse, IsEmpty());
  EXPECT_THAT(gate_sentence(gate), HasSubstr("which of the two is nearer to right is not told"));
  EXPECT_EQ(nearness_of(gate.changes[0], 0.05), Nearness::open);
  for (auto& run : now) run.second *= 0.6;
  EXPECT_EQ(nearness_of(gate_of(factors_of(before), factors_of(now)).changes[0], 0.05), Nearness::farther);
}

TEST(LogGate, OtherStatesAreNotComparedAndMissingRunsAreTold) {
  CheckedLogs logs = checked(factors_of(kWrongRuns));
  logs.analysis.evidence.state_dim = 2;
  logs.gate = gate_against(logs, "before.json", baseline_of(factors_of(kRightRuns)), kMargin);
  EXPECT_THAT(gate_sentence(*logs.gate), HasSubstr("as it is of 0 states and these logs are of 2 states"));
  EXPECT_TRUE(fails(logs)) << "the word decides";
  const LogGate fewer = gate_of(factors_of(with(kRightRuns, {{"gone", 1.0}})), factors_of(kRightRuns));
  EXPECT_THAT(gate_sentence(fewer), HasSubstr("1 of its 9 runs are not here."));
}

TEST(LogGate, RowsThatWereRejectedBeforeDoNotFailAndMoreOfThemDo) {
  const auto gate_with = [](std::int64_t rejected) {
    CheckedLogs logs = checked(factors_of(kRightRuns), Verdict::consistent);
    logs.analysis.evidence.rows = 1000;
    logs.analysis.evidence.rejected["P has a negative variance"] = {.count = rejected, .first = "a.csv:9"};
    Json before = Json::parse(baseline_of(factors_of(kRightRuns), "consistent"));
    before["rows"] = 1000;
    before["rejected_rows"] = 2;
    logs.gate = gate_against(logs, "before.json", text_of_json(before), kMargin);
    return logs;
  };
  EXPECT_FALSE(lost_any(gate_with(2)));
  EXPECT_THAT(junit_xml(gate_with(2), 0.95), HasSubstr("failures=\"0\""));
  EXPECT_TRUE(lost_any(gate_with(3)));
  EXPECT_THAT(gate_with(3).gate->worse,
              testing::ElementsAre("3 of 1000 rows are rejected, before 2 of 1000"));
  CheckedLogs alone = gate_with(2);
  alone.gate.reset();
  EXPECT_TRUE(lost_any(alone));
}

TEST(LogGate, MoreRowsThatErrWherePClaimsCertaintyFail) {
  const auto gate_with = [](std::int64_t of_z) {
    CheckedLogs logs = checked(factors_of(kRightRuns), Verdict::consistent);
    logs.analysis.evidence.rows = 1000;
    logs.analysis.evidence.wrongly_certain = {{"y", {.count = 1}}, {"z", {.count = of_z}}};
    Json before = Json::parse(baseline_of(factors_of(kRightRuns), "consistent"));
    before["rows"] = 1000;
    before["wrongly_certain"] = {{{"state", "z"}, {"count", 4}}, {{"state", "y"}, {"count", 2}}};
    logs.gate = gate_against(logs, "before.json", text_of_json(before), kMargin);
    return logs;
  };
  EXPECT_FALSE(lost_any(gate_with(4)));
  EXPECT_TRUE(lost_any(gate_with(5)));
  EXPECT_THAT(gate_with(5).gate->worse,
              testing::ElementsAre("5 of 1000 rows err where P claims certainty, before 4 of 1000"));
  CheckedLogs alone = gate_with(4);
  alone.gate.reset();
  EXPECT_TRUE(lost_any(alone));
}

/// A mean NEES or NIS that lies within its bounds for factors from lower to upper.
ConsistencyVerdict mean_of(double factor, double lower, double upper) {
  ConsistencyVerdict v;
  v.mean = 2.0 * factor;
  v.expected = 2.0;
  v.bounds = {v.mean / upper, v.mean / lower};
  v.confidence = 0.95;
  v.tests = 11;
  return v;
}

// Of factors known to 10 % at 97.5 %, a standard deviation of 0.1/2.2414 of the logarithm each, p of the
// ratio 1.3 is that of log 1.3 / (√2 · 0.1/2.2414) = 4.158 standard deviations, 3.2e-5, and of two parts
// twice that.
TEST(LogGate, WhereNoFactorsArePairedTheMeansAreCompared) {
  const auto logs_with = [](double nees, double nis) {
    const auto known = [](double factor) {
      return mean_of(factor, factor * std::exp(-0.1), factor * std::exp(0.1));
    };
    CheckedLogs logs = checked(factors_of({}));
    logs.analysis.judgement.nees = known(nees);
    logs.analysis.judgement.sensors.push_back({.name = "gps", .nis = known(nis)});
    return logs;
  };
  const auto gate = [&](const CheckedLogs& before, const CheckedLogs& now) {
    const Judgement& j = before.analysis.judgement;
    const std::string document =
        text_of_json({{"verdict", "optimistic"},
                      {"unmatched_rows", 0},
                      {"nees", verdict_json(j.nees)},
                      {"sensors", {{{"name", "gps"}, {"nis", verdict_json(j.sensors[0].nis)}}}}});
    return gate_against(now, "before.json", document, kMargin);
  };
  const CheckedLogs before = logs_with(1.5, 1.5);
  const LogGate worse = gate(before, logs_with(1.5 * 1.3, 1.5));
  EXPECT_TRUE(worse.by_means);
  ASSERT_THAT(worse.changes, SizeIs(2));
  EXPECT_NEAR(worse.changes[0].ratio.mean, 1.3, 1e-12);
  EXPECT_NEAR(worse.changes[0].p_value, 3.2e-5, 0.05e-5);
  EXPECT_NEAR(worse.changes[0].adjusted, 6.4e-5, 0.1e-5);
  EXPECT_NEAR(worse.changes[1].p_value, 1.0, 1e-12);
  ASSERT_THAT(worse.worse, SizeIs(1));
  EXPECT_THAT(worse.worse[0], HasSubstr("more optimistic in the whole state: the factor on P is 1.30"));
  EXPECT_THAT(gate_sentence(worse), HasSubstr("Mean NEES and NIS were compared"));
  EXPECT_THAT(gate(before, logs_with(1.5, 1.95)).worse.at(0),
              HasSubstr("in NIS of gps: the factor on S is 1.30"));
  EXPECT_THAT(gate(before, logs_with(1.2, 1.2)).worse, IsEmpty()) << "nearer to 1";
  EXPECT_THAT(gate(before, logs_with(1.65, 1.65)).worse, IsEmpty()) << "within what is known";
  CheckedLogs same = logs_with(1.5, 1.5);
  same.gate = gate(before, same);
  EXPECT_FALSE(fails(same)) << "as wrong as it was";
}

TEST(LogGate, WhereNothingIsPairedTheWordDecides) {
  const UnitFactors before = factors_of({{"a", 1.0}, {"b", 1.1}, {"c", 0.9}});
  const auto judged = [&](Verdict now) {
    CheckedLogs logs = checked(factors_of({{"x", 9.0}, {"y", 9.1}, {"z", 8.9}}), now);
    logs.gate = gate_against(logs, "before.json", baseline_of(before), kMargin);
    EXPECT_THAT(gate_sentence(*logs.gate),
                testing::StartsWith("Against before.json (optimistic): Nothing could be compared"));
    return logs;
  };
  const CheckedLogs wrong = judged(Verdict::optimistic), right = judged(Verdict::consistent);
  EXPECT_THAT(wrong.gate->worse, IsEmpty()) << "it was optimistic before";
  EXPECT_TRUE(fails(wrong));
  EXPECT_THAT(junit_xml(wrong, 0.95), HasSubstr("tests=\"2\" failures=\"1\" errors=\"0\" skipped=\"1\""));
  EXPECT_FALSE(fails(right));
  EXPECT_THAT(junit_xml(right, 0.95), HasSubstr("tests=\"2\" failures=\"0\" errors=\"0\" skipped=\"1\""));
}

TEST(LogGate, WhatIsNoDocumentOfCheckIsRefusedByItsName) {
  const CheckedLogs logs = checked(factors_of({}));
  for (
      const char* text :
      {"[]", "7", R"({"verdict": "bananas", "nees": {}, "unmatched_rows": 0})", R"({"nees": {}})",
       R"({"verdict": 1, "nees": {}})", R"({"verdict": "mixed", "nees": {}})",
       R"({"verdict": "mixed", "nees": {}, "unmatched_rows": 0, "outcomes": 5})",
       R"({"verdict": "mixed", "nees": {}, "unmatched_rows": 0, "calibration": {"units": "runs", "unit_names": 5}})",
       R"({"verdict": "mixed", "nees": {}, "unmatched_rows": 0, "calibration": {"units": "runs", "unit_names": [5]}})"}) {
    EXPECT_THAT([&] { gate_against(logs, "old.json", text, kMargin); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("--baseline old.json: is not a document of")))
        << text;
  }
  EXPECT_THAT([&] { gate_against(logs, "old.json", "", kMargin); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("--baseline old.json: is empty")));
  EXPECT_THAT([&] { gate_against(logs, "old.json", "{", kMargin); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("--baseline old.json:1: is no JSON")));
  EXPECT_THAT([&] { gate_against(logs, "old.json", R"({"schema": 99})", kMargin); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("--baseline old.json: schema = 99")));
  EXPECT_THAT(
      [&] {
        gate_against(logs, "old.json", R"({"verdict": "mixed", "nees": {"mean": -2}, "unmatched_rows": 0})",
                     kMargin);
      },
      ThrowsMessage<std::invalid_argument>("--baseline old.json: nees.mean = -2: must be at least 0"));
}

NamedTest named(const char* name, double p, double adjusted) {
  return {.name = name, .exactness = Exactness::exact, .p_value = p, .adjusted = adjusted, .says = "a < b"};
}

TEST(JunitXml, FailuresAreThereExactlyWhereTheCheckFails) {
  CheckedLogs logs = checked(factors_of({}));
  logs.analysis.judgement.tests = {named("mean & \"law\"", 1e-9, 1e-8), named("whiteness", 0.02, 0.2),
                                   named("bias", kNaN, kNaN)};
  const std::string xml = junit_xml(logs, 0.95);
  EXPECT_TRUE(fails(logs));
  EXPECT_THAT(xml, HasSubstr("tests=\"4\" failures=\"2\" errors=\"0\" skipped=\"1\""));
  EXPECT_THAT(xml, HasSubstr("name=\"mean &amp; &quot;law&quot;\"><failure message=\"a &lt; b; p = "));
  EXPECT_THAT(xml, HasSubstr("name=\"bias\"><skipped message=\"a &lt; b\"/>"));
  logs.gate = LogGate{.baseline = "old.json", .changes = std::vector<FactorChange>(1)};
  EXPECT_FALSE(fails(logs)) << "as wrong as it was";
  EXPECT_THAT(junit_xml(logs, 0.95), HasSubstr("tests=\"5\" failures=\"0\" errors=\"0\" skipped=\"3\""))
      << "what was wrong before has not passed";
  EXPECT_THAT(junit_xml(logs, 0.95), HasSubstr("(only what is worse than old.json fails)\"/>"));
  logs.gate->worse = {"it is worse"};
  EXPECT_TRUE(fails(logs));
  EXPECT_THAT(junit_xml(logs, 0.95), HasSubstr("tests=\"5\" failures=\"1\" errors=\"0\" skipped=\"3\""));
  logs.gate.reset();
  logs.analysis.judgement.word.verdict = Verdict::undecided;
  EXPECT_FALSE(fails(logs));
  EXPECT_THAT(junit_xml(logs, 0.95), HasSubstr("tests=\"4\" failures=\"0\" errors=\"0\" skipped=\"2\""));
}

// A consistent word over what is left is no success of the filter.
TEST(JunitXml, RunsAndRowsThatWereNotJudgedFail) {
  CheckedLogs logs = checked(factors_of({}));
  logs.analysis.judgement.word.verdict = Verdict::consistent;
  EXPECT_THAT(junit_xml(logs, 0.95), HasSubstr("tests=\"1\" failures=\"0\""));
  Evidence& e = logs.analysis.evidence;
  e.study.runs = 30;
  e.study.failures = {{.run = 3, .step = 7, .outcome = Outcome::diverged}};
  e.rows = 4000;
  e.rejected["P has a negative variance"] = {.count = 2, .first = "a.csv:9"};
  e.wrongly_certain["z"] = {.count = 7};
  const char* const says =
      "1 of 30 runs failed; 2 of 4000 rows were rejected; z errs in 7 of 4000 rows where P claims certainty";
  EXPECT_THAT(junit_xml(logs, 0.95), HasSubstr("tests=\"2\" failures=\"1\""));
  EXPECT_THAT(junit_xml(logs, 0.95), HasSubstr(says));
  EXPECT_THAT(markdown_summary(logs), HasSubstr(says));
}

TEST(MarkdownSummary, ABarInANameDoesNotEndItsCell) {
  CheckedLogs logs = checked(factors_of({}));
  BlockSums& sums = logs.analysis.evidence.blocks.emplace_back();
  sums.name = "a|b";
  ConsistencyVerdict verdict;
  verdict.count = 3;
  logs.analysis.judgement.blocks.push_back({"a|b", verdict});
  logs.remarks = {"half of it was cut off"};
  const std::string text = markdown_summary(logs);
  EXPECT_THAT(text, HasSubstr("## logs: optimistic\n"));
  EXPECT_THAT(text, HasSubstr("| NEES of a\\|b |"));
  EXPECT_THAT(text, HasSubstr("\n- half of it was cut off\n"));
}

TEST(MarkdownSummary, NoNameIsALinkOrHides) {
  CheckedLogs logs = checked(factors_of({}));
  logs.remarks = {"[log](http://a.b) `x` *y*\u202E"};
  EXPECT_THAT(markdown_summary(logs), HasSubstr("\n- \\[log\\](http:&#47;/a.b) \\`x\\` \\*y\\*\n"));
}

TEST(MarkdownSummary, NoNameIsHtml) {
  CheckedLogs logs = checked(factors_of({}));
  logs.name = "a & <img src=x onerror=alert(1)>";
  logs.analysis.evidence.blocks.emplace_back().name = "<b>";
  ConsistencyVerdict verdict;
  verdict.count = 3;
  logs.analysis.judgement.blocks.push_back({"<b>", verdict});
  logs.remarks = {"<script>.csv: cut off"};
  const std::string text = markdown_summary(logs);
  EXPECT_THAT(text, HasSubstr("## a &amp; &lt;img src=x onerror=alert(1)>: optimistic\n"));
  EXPECT_THAT(text, HasSubstr("| NEES of &lt;b> |"));
  EXPECT_THAT(text, HasSubstr("\n- &lt;script>.csv: cut off\n"));
  EXPECT_EQ(text.find('<'), std::string::npos);
}

TEST(MarkdownSummary, TheNameOfAFileIsOneLine) {
  CheckedLogs logs = checked(factors_of({}));
  logs.name = "a\n# b\x1b.csv";
  const std::string text = markdown_summary(logs);
  EXPECT_EQ(text.substr(0, 4), "## a");
  EXPECT_EQ(text.find("\n# b"), std::string::npos);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace credence::internal
