#include "reports/document/logs/log_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "analysis/evidence/sums/step_series.h"
#include "analysis/evidence/verdicts/judgement_tests.h"
#include "core/append_item.h"
#include "core/number_text.h"
#include "reports/document/logs/log_gate.h"
#include "reports/document/study/judgement_report.h"
#include "reports/document/verdict_text.h"

namespace credence::internal {
namespace {

void add_verdict(ReportTable& table, const std::string& what, const ConsistencyVerdict& v) {
  if (v.count == 0) return;
  // As among all tests, where what is undecided has none.
  const std::string p_value = v.verdict == Verdict::undecided ? "–" : p_value_text(v.p_value);
  table.add({what, verdict_cell(v.verdict), v.mean, v.expected, trusted_text(v), p_value, v.count});
}

/// Whether a row says what the answer, which joins them all, does not, or what it fails no more beside all
/// other tests.
bool rejects_alone(const Judgement& a) {
  const Verdict word = a.word.verdict;
  if (word == Verdict::not_gaussian) return false;
  const auto alone = [&](const std::string& test, Verdict row) {
    if (!is_inconsistent(row)) return false;
    if (word != Verdict::mixed && row != word) return true;
    return std::ranges::count(a.tests, test, &NamedTest::name) > 0 && !speaks(a, test);
  };
  const auto of_block = [&](const BlockVerdict& b) { return alone("NEES of " + b.name, b.verdict.verdict); };
  const auto of_nis = [&](const SensorJudgement& s) { return alone(of_sensor("NIS", s), s.nis.verdict); };
  return alone("NEES", a.nees.verdict) || alone("NIS", a.nis.verdict) ||
         std::ranges::any_of(a.blocks, of_block) || std::ranges::any_of(a.sensors, of_nis);
}

std::string tests_of(const SensorJudgement& s) {
  const std::string name = s.name.empty() ? "innovation" : s.name;
  const auto p = [](double value, std::string_view reason) {
    return reason.empty() ? " " + p_value_statement(value) : fmt::format(": {}", reason);
  };
  const auto of_each = [&](const ComponentTest& test, const char* what) {
    if (test.components.empty()) return std::string();
    return fmt::format("; of {}{}", what, p(std::min(test.p_value.optimistic, test.p_value.pessimistic), ""));
  };
  const double over_time = s.over_time.p_value;
  return fmt::format(
      "{}: test of whiteness in time{}; of mean zero{}{}{}{}.", name,
      p(s.whiteness.p_value, s.whiteness.reason), p(s.mean.p_value, s.mean.reason),
      of_each(s.components, "each component alone"), of_each(s.pairs, "every two together"),
      std::isnan(over_time) ? "" : "; of NIS that goes up and down in time " + p_value_statement(over_time));
}

/// Of a row that a step decided, the mean of which may lie within the interval beside it.
void add_step_note(ReportTable& table, double confidence) {
  const auto by_step = [](const std::vector<TableCell>& row) {
    return row[4].text.find(", has ") != std::string::npos;
  };
  if (std::ranges::none_of(table.rows, by_step)) return;
  table.notes.push_back(fmt::format(
      "“at step k, has …”: that step decided, and the interval is the one for its mean. With {:g} % "
      "probability all steps of a right filter lie within theirs. The column “mean” is over all steps; runs "
      "of different lengths count alike, or by the stretches that a few long ones are cut into.",
      100.0 * confidence));
}

/// Why the answer says "at some times" and "at others", of which no row does.
void add_over_time(ReportTable& table, const Judgement& a) {
  const auto named = [&a](const std::string& part) {
    return std::ranges::count(a.word.named, part + kAtSomeTimes) > 0 ||
           std::ranges::count(a.word.named, part + kAtOthers) > 0;
  };
  for (const NeesOverTime& nees : a.nees_over_time) {
    if (!named(nees.part())) continue;
    table.notes.push_back(fmt::format(
        "At some times, at others: {} goes up and down in time by more than the memory of the "
        "errors makes ({}), most in waves of about {:.0f} rows. Its mean may be right all the "
        "same.",
        nees.of.empty() ? "NEES" : "NEES of " + nees.of, p_value_statement(nees.p_value), nees.wave));
  }
  for (const SensorJudgement& sensor : a.sensors) {
    const std::string nis = of_sensor("NIS", sensor);
    if (!named(nis)) continue;
    table.notes.push_back(
        fmt::format("At some times, at others: {} goes up and down in time ({}), most in waves of about "
                    "{:.0f} steps. Its mean may be right all the same.",
                    nis, p_value_statement(sensor.over_time.p_value), sensor.over_time.wave));
  }
}

void add_read_notes(ReportTable& table, const CheckedLogs& logs) {
  const Evidence& s = logs.analysis.evidence;
  const std::string files = logs.files == 0 ? "" : " in " + counted(logs.files, "file");
  table.notes.push_back(fmt::format("{} of {}{} ({}).{}", counted(s.rows, "row"),
                                    counted(s.study.runs, "run"), files, logs.format,
                                    logs.analysis.complete ? "" : " Interrupted."));
  if (s.step_stride > 1) {
    table.notes.push_back(
        fmt::format("These runs are longer than {} steps. What is judged step by step, and the values "
                    "counted above, are of every {} step; averages of runs, the factor on P and tests of "
                    "innovations over time are of all.",
                    kMostSteps, ordinal(s.step_stride)));
  }
  if (logs.unmatched_rows > 0) {
    table.notes.push_back(
        fmt::format("No truth at their time, and left out: {}.", counted(logs.unmatched_rows, "row")));
  }
  if (!logs.poses.empty()) {
    table.notes.push_back(fmt::format("The covariance of the pose is judged as of the chart {} (--chart).",
                                      logs.poses.front().charts.declared));
  }
  constexpr std::size_t kRemarks = 12;
  const std::vector<std::string> remarks = logs.all_remarks();
  for (std::size_t i = 0; i < std::min(kRemarks, remarks.size()); ++i) {
    table.notes.push_back(remarks[i]);
  }
  if (remarks.size() > kRemarks) {
    table.notes.push_back(fmt::format("{} more remarks are in the JSON.", remarks.size() - kRemarks));
  }
  if (!s.has_truth && logs.analysis.judgement.nis.count > 0) {
    table.notes.push_back(
        "Without a truth the innovations alone are judged: whether P is right where no sensor measures, and "
        "a bias that all sensors share, cannot be known from them.");
  }
  for (const auto& [reason, rows] : s.rejected) {
    table.notes.push_back(fmt::format("REJECTED: {}, {}{}.", counted(rows.count, "row"), reason,
                                      rows.first.empty() ? "" : fmt::format(" (first: {})", rows.first)));
  }
  for (const auto& [state, rows] : s.wrongly_certain) {
    table.notes.push_back(
        fmt::format("LEFT OUT: {} in {}, where P claims certainty (variance 0) and it errs{}. A state "
                    "that the filter "
                    "does not estimate belongs in no log; of poses in the plane: --orientation-error planar.",
                    state, counted(rows.count, "row"),
                    rows.first.empty() ? "" : fmt::format(" (first: {})", rows.first)));
  }
  if (s.rejected.contains("a zero variance has a covariance")) {
    table.notes.emplace_back(
        "Variances of P or S are 0 there: were small ones written with a fixed number of decimals, as by "
        "%.4f (nine significant digits, %.9g, are enough), or is it the lower triangle where the upper one "
        "is expected?");
  }
  for (const RunFailure& f : s.study.failures) {
    const auto said = logs.failures_said.find(f.run);
    const auto run = static_cast<std::size_t>(f.run);
    const std::string name = run < logs.run_names.size() ? logs.run_names[run] : fmt::format("run {}", run);
    table.notes.push_back(fmt::format("FAILED: {}, {} at step {}{}.", name, to_string(f.outcome), f.step,
                                      said == logs.failures_said.end() ? "" : ": " + said->second));
    if (s.study.failures.size() > 5) {
      table.notes.push_back(fmt::format("… {} runs failed in all.", s.study.failures.size()));
      break;
    }
  }
  if (const auto failed = std::ssize(s.study.failures); failed > 0)
    table.notes.push_back(what_failed_count_in(failed, s.study.runs) + ".");
}

/// Where a block stands in a table: the pose first, then its parts, the rest in the order of the log.
int rank_of(const Evidence& evidence, const std::string& block) {
  const auto found = std::ranges::find(evidence.blocks, block, &BlockSums::name);
  if (found == evidence.blocks.end()) return 3;
  return found->part == Part::pose       ? 0
         : found->part == Part::position ? 1
         : found->part == Part::heading  ? 2
                                         : 3;
}

/// The blocks that a short table has, in their order: those that the answer names, the pose and its parts,
/// then the inconsistent ones before the others, and of these the ones that are wrong by the largest factor.
std::vector<const BlockVerdict*> worst_of(const LogAnalysis& a, std::vector<const BlockVerdict*> blocks,
                                          std::size_t most) {
  const auto matters = [&a](const BlockVerdict* b) {
    const double factor = std::abs(std::log(b->verdict.mean / b->verdict.expected));
    const bool named = std::ranges::count(a.judgement.word.named, b->name) > 0;
    return std::tuple(named, -rank_of(a.evidence, b->name), is_inconsistent(b->verdict.verdict),
                      std::isnan(factor) ? 0.0 : factor);
  };
  std::vector<const BlockVerdict*> worst = blocks;
  std::ranges::stable_sort(worst, std::ranges::greater(), matters);
  worst.resize(std::min(most, worst.size()));
  std::erase_if(blocks, [&](const BlockVerdict* b) { return std::ranges::find(worst, b) == worst.end(); });
  return blocks;
}

/// Of a log that says what the filter believes, and nothing by which that could be seen to be wrong.
bool nothing_to_judge(const LogAnalysis& a) {
  return a.judgement.nees.count == 0 && a.judgement.nis.count == 0 && a.evidence.rejected.empty() &&
         a.evidence.wrongly_certain.empty();
}

std::string why_undecided(const LogAnalysis& a) {
  const Judgement& j = a.judgement;
  if (!j.word.says.empty()) return j.word.says;
  if (!nothing_to_judge(a)) return j.nees.reason;
  return std::string(a.evidence.has_truth ? "no row has an error with a variance"
                                          : "there is no truth to compare with") +
         ", and there are no innovations; nothing is judged";
}

}  // namespace

std::vector<const BlockVerdict*> blocks_in_order(const LogAnalysis& a) {
  std::vector<const BlockVerdict*> blocks;
  for (const BlockVerdict& block : a.judgement.blocks) blocks.push_back(&block);
  std::ranges::stable_sort(blocks, {}, [&](const BlockVerdict* b) { return rank_of(a.evidence, b->name); });
  return blocks;
}

namespace {

/// Of the rows that there are.
std::string answer_of_verdicts(const CheckedLogs& logs) {
  const Judgement& a = logs.analysis.judgement;
  const bool has_truth = logs.analysis.evidence.has_truth;
  const std::string asked = "Can this covariance be trusted? ";
  const std::string says =
      a.word.says.empty() ? std::string(to_string(a.word.verdict)) : word_clause(a.word, a.nees, a.blocks);
  switch (a.word.verdict) {
    case Verdict::optimistic: return asked + "No: " + says;
    case Verdict::mixed: return asked + (a.word.says.empty() ? "No: " : "No: mixed: ") + says;
    case Verdict::pessimistic:
      return asked +
             (a.word.of_S_alone ? "S is larger than the innovations: "
              : has_truth       ? "Yes, but it is larger than the errors: "
                                : "It is larger than the innovations say: ") +
             says;
    case Verdict::not_gaussian: return asked + "Yes: " + says;
    case Verdict::undecided: {
      const std::string why = why_undecided(logs.analysis);
      return asked + "Undecided" + (why.empty() ? "" : ": " + why);
    }
    case Verdict::consistent: break;
  }
  if (has_truth) return asked + "Yes, nothing speaks against it: consistent" + power_clause(a);
  return asked +
         "Yes, as far as innovations can tell: consistent; without a truth they cannot tell whether P is "
         "right";
}

}  // namespace

/// The verdicts are of the rows before a run failed: that it did, is no less a fault.
std::string log_answer(const CheckedLogs& logs) {
  std::string answer = answer_of_verdicts(logs);
  const StudyStatistics& s = logs.analysis.evidence.study;
  if (s.failures.empty()) return answer;
  const std::string failed = failed_text(std::ssize(s.failures), s.runs);
  if (answer.find(failed) == std::string::npos) answer += "; " + failed;
  return answer;
}

ReportTable log_verdicts(const CheckedLogs& logs, std::size_t most_blocks) {
  using enum ColumnAlign;
  const Judgement& a = logs.analysis.judgement;
  ReportTable table{.title = log_answer(logs),
                    .columns = {{"what", words},
                                {"verdict", words},
                                {"mean"},
                                {"expected"},
                                {"trusted if within", words},
                                {"p", words},
                                {"values"}}};
  add_verdict(table, "NEES", a.nees);
  add_verdict(table, "NIS", a.nis);
  const std::vector<const BlockVerdict*> blocks = blocks_in_order(logs.analysis);
  for (const BlockVerdict* block : worst_of(logs.analysis, blocks, most_blocks)) {
    add_verdict(table, "NEES of " + block->name, block->verdict);
  }
  if (blocks.size() > most_blocks) {
    table.notes.push_back(
        fmt::format("{} more blocks are in the JSON and on the page.", blocks.size() - most_blocks));
  }
  if (a.sensors.size() > 1) {
    for (const SensorJudgement& s : a.sensors) add_verdict(table, "NIS of " + s.name, s.nis);
  }
  if (a.sensitivity) {
    add_verdict(table, "NEES without outliers", a.sensitivity->nees);
    add_verdict(table, "NIS without outliers", a.sensitivity->nis);
    table.notes.push_back(
        fmt::format("Gross outliers, beyond the upper {} quantile of their law: {} of NEES, {} of NIS.",
                    short_text(kGrossOutlier), a.sensitivity->nees_outliers, a.sensitivity->nis_outliers));
  }
  if (table.rows.empty()) table.columns.clear();
  if (rejects_alone(a)) {
    table.notes.push_back(fmt::format(
        "Each row is judged by itself at {0:g} %, so that of several one rejects a right filter "
        "more often. The answer joins them all, at {0:g} % together: what it does not say is no evidence, "
        "and neither is a row that “fails alone” among all tests.",
        100.0 * (1.0 - a.confidence)));
  }
  add_step_note(table, a.confidence);
  add_over_time(table, a);
  add_read_notes(table, logs);
  if (!a.nees.reason.empty() && logs.analysis.evidence.has_truth) {
    table.notes.push_back("NEES: " + a.nees.reason + ".");
  }
  if (a.word.verdict == Verdict::not_gaussian) {
    table.notes.push_back(
        "not Gaussian: P is right. The verdicts of the rows assume a Gaussian law, which these errors do not "
        "have.");
  }
  return table;
}

std::vector<std::string> log_statistics(const Judgement& a) {
  std::vector<std::string> sentences;
  std::string over_time;
  for (const NeesOverTime& nees : a.nees_over_time)
    append_item(over_time, (nees.of.empty() ? "" : "of " + nees.of + " ") + p_value_statement(nees.p_value));
  if (!over_time.empty()) {
    sentences.push_back(fmt::format(
        "Test whether NEES changes in time, beyond what the memory of the errors makes: {}.", over_time));
  }
  for (const SensorJudgement& s : a.sensors) sentences.push_back(tests_of(s));
  for (const SensorJudgement& s : a.sensors) {
    const std::string name = s.name.empty() ? "" : " of " + s.name;
    if (s.fit.reason.starts_with("not tested"))
      sentences.push_back(fmt::format("NIS{} against its chi-square law: {}.", name, s.fit.reason));
    if (!s.fit.reason.empty()) continue;
    sentences.push_back(
        fmt::format("NIS{} against its chi-square law: Kolmogorov-Smirnov {}, Anderson-Darling {}.", name,
                    p_value_statement(s.fit.kolmogorov_p_value), p_value_statement(s.fit.anderson_p_value)));
  }
  for (std::string& sentence : statistics_sentences(a)) sentences.push_back(std::move(sentence));
  return sentences;
}

ReportTable log_table(const CheckedLogs& logs) {
  constexpr std::size_t kShown = 12;
  const Judgement& a = logs.analysis.judgement;
  ReportTable table = log_verdicts(logs, kShown);
  const auto note = [&table](std::vector<std::string> sentences) {
    for (std::string& sentence : sentences) table.notes.push_back(std::move(sentence));
  };
  note(logs.advice());
  if (logs.gate) note({gate_sentence(*logs.gate)});
  note(logs.factor_sentences());
  note(log_statistics(a));
  note(
      {"consistent: no evidence against P. optimistic: errors are larger than P says; do not trust it. "
       "pessimistic: smaller. mixed: larger here, smaller there; do not trust it."});
  return table;
}

}  // namespace credence::internal
