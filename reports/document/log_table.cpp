#include <fmt/format.h>

#include <algorithm>

#include "reports/document/judgement_report.h"
#include "reports/document/log_report.h"
#include "reports/document/study_table.h"
#include "reports/render/number_text.h"

namespace credence {
namespace {

void add_verdict(ReportTable& table, const std::string& what, const ConsistencyVerdict& v) {
  if (v.count == 0) return;
  table.add({what, v.count, v.mean, v.expected,
             fmt::format("{} … {}", number_text(v.bounds.lower), number_text(v.bounds.upper)),
             number_text(v.p_value, 3), verdict_cell(v.verdict)});
}

std::string tests_of(const SensorJudgement& s) {
  const std::string name = s.name.empty() ? "innovation" : s.name;
  const auto p = [](double value, std::string_view reason) {
    return reason.empty() ? "p = " + number_text(value, 3) : std::string(reason);
  };
  return fmt::format("{}: test of whiteness in time {}; of mean zero {}.", name,
                     p(s.whiteness.p_value, s.whiteness.reason), p(s.mean.p_value, s.mean.reason));
}

void add_read_notes(ReportTable& table, const CheckedLogs& logs) {
  const Evidence& s = logs.analysis.evidence;
  const std::string files = logs.files == 0 ? "" : fmt::format(" in {} files", logs.files);
  table.notes.push_back(fmt::format("{} rows of {} runs{} ({}).{}", s.rows, s.study.runs, files, logs.format,
                                    logs.analysis.complete ? "" : " Interrupted."));
  if (logs.unmatched_rows > 0) {
    table.notes.push_back(
        fmt::format("{} rows have no truth at their time and are left out.", logs.unmatched_rows));
  }
  constexpr std::size_t kRemarks = 12;
  for (std::size_t i = 0; i < std::min(kRemarks, logs.remarks.size()); ++i) {
    table.notes.push_back(logs.remarks[i]);
  }
  if (logs.remarks.size() > kRemarks) {
    table.notes.push_back(fmt::format("{} more remarks are in the JSON.", logs.remarks.size() - kRemarks));
  }
  if (!s.has_truth && logs.analysis.judgement.nis.count > 0) {
    table.notes.push_back(
        "Without a truth the innovations alone are judged: whether P is right where no sensor measures, and "
        "a bias that all sensors share, cannot be known from them.");
  }
  for (const auto& [reason, rows] : s.rejected) {
    table.notes.push_back(fmt::format("REJECTED: {} rows, {} (first: {}).", rows.count, reason, rows.first));
  }
  for (const RunFailure& f : s.study.failures) {
    const auto said = logs.failures_said.find(f.run);
    table.notes.push_back(fmt::format("FAILED: run {}, {} at step {}{}.", f.run, to_string(f.outcome), f.step,
                                      said == logs.failures_said.end() ? "" : ": " + said->second));
    if (s.study.failures.size() > 5) {
      table.notes.push_back(fmt::format("… {} runs failed in all.", s.study.failures.size()));
      break;
    }
  }
}

}  // namespace

ReportTable log_table(const CheckedLogs& logs) {
  using enum ColumnAlign;
  const Evidence& evidence = logs.analysis.evidence;
  const Judgement& a = logs.analysis.judgement;
  ReportTable table{.title = fmt::format("Can this covariance be trusted? {}", to_string(a.word.verdict)),
                    .columns = {{"what", words},
                                {"values"},
                                {"mean"},
                                {"expected"},
                                {"trusted if within", words},
                                {"p", words},
                                {"verdict", words}},
                    .rows = {},
                    .notes = {}};
  add_verdict(table, "NEES", a.nees);
  add_verdict(table, "NIS", a.nis);
  constexpr std::size_t kShown = 12;
  for (std::size_t i = 0; i < a.blocks.size() && i < kShown; ++i) {
    add_verdict(table, "NEES of " + a.blocks[i].name, a.blocks[i].verdict);
  }
  if (a.blocks.size() > kShown) {
    table.notes.push_back(
        fmt::format("{} more blocks are in the JSON and on the page.", a.blocks.size() - kShown));
  }
  if (a.sensors.size() > 1) {
    for (const SensorJudgement& s : a.sensors) add_verdict(table, "NIS of " + s.name, s.nis);
  }
  if (a.sensitivity) {
    add_verdict(table, "NEES without outliers", a.sensitivity->nees);
    add_verdict(table, "NIS without outliers", a.sensitivity->nis);
    table.notes.push_back(
        fmt::format("Gross outliers, beyond the upper {:g} quantile of their law: {} of NEES, {} of NIS.",
                    kGrossOutlier, a.sensitivity->nees_outliers, a.sensitivity->nis_outliers));
  }
  if (!a.word.says.empty()) table.notes.push_back(word_sentence(logs.name, a.word, a.nees));
  add_read_notes(table, logs);
  if (!a.nees.reason.empty() && evidence.has_truth) table.notes.push_back("NEES: " + a.nees.reason + ".");
  for (const SensorJudgement& s : a.sensors) table.notes.push_back(tests_of(s));
  for (const SensorJudgement& s : a.sensors) {
    if (!s.fit.reason.empty()) continue;
    table.notes.push_back(
        fmt::format("NIS{} against its chi-square law: Kolmogorov-Smirnov p = {}, Anderson-Darling p = {}.",
                    s.name.empty() ? "" : " of " + s.name, number_text(s.fit.kolmogorov_p_value, 3),
                    number_text(s.fit.anderson_p_value, 3)));
  }
  for (const std::string& sentence : advice_sentences(a)) table.notes.push_back(sentence);
  table.notes.push_back(
      "consistent: nothing speaks against P. optimistic: errors are larger than P says; do not trust it. "
      "pessimistic: smaller. mixed: larger here, smaller there; do not trust it.");
  if (a.word.verdict == Verdict::not_gaussian) {
    table.notes.push_back(
        "not Gaussian: P is right. The verdicts of the rows assume a Gaussian law, which these errors do not "
        "have.");
  }
  return table;
}

}  // namespace credence
