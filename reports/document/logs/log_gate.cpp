#include "reports/document/logs/log_gate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "core/append_item.h"
#include "core/number_text.h"
#include "reports/document/logs/compare_means.h"
#include "reports/document/logs/log_table.h"
#include "reports/document/study/calibration_report.h"
#include "reports/document/study/judgement_report.h"
#include "reports/render/html_text.h"
#include "reports/render/parsed_json.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

bool compared(const CheckedLogs& logs) { return logs.gate && logs.gate->compares(); }

struct JunitCase {
  std::string name, says;
  bool failed = false, skipped = false;
};

std::string junit_case(const JunitCase& c) {
  const std::string begin =
      fmt::format("  <testcase classname=\"credence.check\" name=\"{}\"", escape_html(c.name));
  if (c.skipped) return fmt::format("{}><skipped message=\"{}\"/></testcase>\n", begin, escape_html(c.says));
  if (c.failed) return fmt::format("{}><failure message=\"{}\"/></testcase>\n", begin, escape_html(c.says));
  return fmt::format("{}><system-out>{}</system-out></testcase>\n", begin, escape_html(c.says));
}

/// "212 of 300 runs failed; 3 of 4000 rows were rejected"; "" where all were judged.
std::string not_judged(const Evidence& e) {
  std::string text;
  if (const auto failed = std::ssize(e.study.failures); failed > 0)
    append_item(text, fmt::format("{} of {} runs failed", failed, e.study.runs), "; ");
  if (const std::int64_t rejected = e.rejected_rows(); rejected > 0)
    append_item(text, fmt::format("{} of {} rows were rejected", rejected, e.rows), "; ");
  for (const auto& [state, rows] : e.wrongly_certain)
    append_item(text,
                fmt::format("{} errs in {} of {} rows where P claims certainty", state, rows.count, e.rows),
                "; ");
  return text;
}

std::int64_t whole_number(const Json& in, const char* key) {
  return in.contains(key) && in[key].is_number_integer() ? in[key].get<std::int64_t>() : 0;
}

/// What the states and blocks of two results are, where they differ; else "".
std::string other_states(const CheckedLogs& logs, const Json& before) {
  const auto described = [](std::int64_t states, const std::set<std::string>& blocks) {
    return fmt::format("{}{}{}", counted(states, "state"), blocks.empty() ? "" : " in ",
                       fmt::join(blocks, ", "));
  };
  std::set<std::string> blocks, blocks_before;
  for (const BlockVerdict& block : logs.analysis.judgement.blocks) blocks.insert(block.name);
  const Json of_before = before.value("blocks", Json::object());
  for (const auto& [name, verdict] : of_before.items()) blocks_before.insert(name);
  const std::int64_t states = logs.analysis.evidence.state_dim;
  const std::int64_t states_before = whole_number(before, "state_dim");
  if (states == states_before && blocks == blocks_before) return "";
  return fmt::format("as it is of {} and these logs are of {}", described(states_before, blocks_before),
                     described(states, blocks));
}

/// Where a larger share of runs failed, or of rows was rejected or errs in what P claims to know, than
/// before.
void compare_lost_ones(const Evidence& e, const Json& before, LogGate& gate) {
  const auto compare = [&](std::string_view what, std::int64_t now, std::int64_t all, std::int64_t then,
                           std::int64_t all_then) {
    const auto share = [](std::int64_t lost, std::int64_t of) {
      return static_cast<double>(lost) / static_cast<double>(std::max<std::int64_t>(1, of));
    };
    if (!(share(now, all) > share(then, all_then))) return;
    gate.lost_more = true;
    gate.worse.push_back(fmt::format("{} of {} {}, before {} of {}", now, all, what, then, all_then));
  };
  compare("rows are rejected", e.rejected_rows(), e.rows, whole_number(before, "rejected_rows"),
          whole_number(before, "rows"));
  std::int64_t certain = 0;
  for (const Json& state : before.value("wrongly_certain", Json::array()))
    certain = std::max(certain, whole_number(state, "count"));
  compare("rows err where P claims certainty", e.wrongly_certain_rows(), e.rows, certain,
          whole_number(before, "rows"));
  const Json outcomes = before.value("outcomes", Json::object());
  compare("runs failed", std::ssize(e.study.failures), e.study.runs,
          std::ssize(outcomes.value("failures", Json::array())), whole_number(before, "runs"));
}

}  // namespace

LogGate gate_against(const CheckedLogs& logs, const std::string& baseline, std::string_view document,
                     double margin) {
  const auto refuse = [&] {
    throw std::invalid_argument(
        fmt::format("--baseline {}: is not a document of `credence check --format json`", baseline));
  };
  const Json before = parsed_json("--baseline " + baseline, document);
  require_schema("--baseline " + baseline, before);
  if (!before.is_object() || !before.contains("verdict") || !before.contains("nees") ||
      !before.contains("unmatched_rows") || !before["verdict"].is_string() ||
      !verdict_named(before["verdict"].get<std::string>())) {
    refuse();
  }
  require_possible("--baseline " + baseline, before);
  const Judgement& now = logs.analysis.judgement;
  LogGate gate;
  gate.baseline = baseline;
  gate.level = 1.0 - now.confidence;
  gate.verdict_before = before["verdict"].get<std::string>();
  const Verdict then = *verdict_named(gate.verdict_before);
  gate.became_inconsistent = is_inconsistent(now.word.verdict) &&
                             (!is_inconsistent(then) || (is_unsafe(now.word.verdict) && !is_unsafe(then)));
  if (gate.became_inconsistent) {
    gate.worse.push_back(
        fmt::format("it was {}, and is {}", gate.verdict_before, to_string(now.word.verdict)));
  }
  UnitFactors first;
  try {
    first = unit_factors_of(before.value("calibration", Json::object()));
    gate.why_not = other_states(logs, before);
    if (!gate.why_not.empty()) return gate;
    compare_lost_ones(logs.analysis.evidence, before, gate);
  } catch (const Json::exception&) {
    refuse();
  }
  gate.changes = compare_factors(logs.units, first, now.confidence);
  if (first.units == "runs") {
    gate.runs_before = std::ssize(first.names);
    gate.missing_runs = std::ranges::count_if(first.names, [&](const std::string& name) {
      return std::ranges::find(logs.units.names, name) == logs.units.names.end();
    });
  }
  if (first.names.empty() || logs.units.names.empty()) {
    try {
      compare_means(now, before, gate);
    } catch (const Json::exception&) {
      refuse();
    }
  } else if (gate.changes.empty()) {
    gate.why_not = "as no runs or stretches of the same name have a factor on P in both";
  }
  for (const FactorChange& change : gate.changes) {
    const bool large = std::abs(std::log(change.ratio.mean)) > std::log1p(margin);
    if (large && nearness_of(change, gate.level) == Nearness::farther)
      gate.worse.push_back(change_text(change, gate.level));
  }
  return gate;
}

std::string change_text(const FactorChange& change, double level) {
  const Nearness nearness = nearness_of(change, level);
  return fmt::format("{} in {}: the factor on {} is {} times what it was, {}{}",
                     nearness == Nearness::nearer ? "nearer to right"
                     : nearness == Nearness::open ? "changed"
                     : change.ratio.mean > 1.0    ? "more optimistic"
                                                  : "more pessimistic",
                     change.part == "NEES" ? "the whole state" : change.part, change.on,
                     interval_text(change.ratio.mean, change.ratio.lower, change.ratio.upper),
                     p_value_statement(change.adjusted),
                     nearness == Nearness::open && change.adjusted <= level
                         ? "; which of the two is nearer to right is not told"
                         : "");
}

std::string gate_sentence(const LogGate& gate) {
  std::string text = fmt::format("Against {} ({}):", gate.baseline, gate.verdict_before);
  if (!gate.worse.empty()) text += fmt::format(" WORSE: {}.", fmt::join(gate.worse, "; "));
  if (!gate.compares()) {
    return text + fmt::format(" Nothing could be compared, {}; the verdict counts as without a baseline.",
                              gate.why_not);
  }
  if (gate.worse.empty()) {
    text += " nothing is worse.";
    for (const FactorChange& change : gate.changes) {
      if (change.adjusted <= gate.level) text += " It is " + change_text(change, gate.level) + ".";
    }
  }
  if (gate.missing_runs > 0)
    text += fmt::format(" {} of its {} runs are not here.", gate.missing_runs, gate.runs_before);
  if (gate.by_means)
    text += " Mean NEES and NIS were compared, as there are no factors of runs or stretches to pair.";
  return text;
}

Json change_json(const FactorChange& change) {
  return {{"part", change.part},
          {"ratio", change.ratio.mean},
          {"lower", change.ratio.lower},
          {"upper", change.ratio.upper},
          {"p_value", change.p_value},
          {"adjusted_p_value", change.adjusted},
          {"middle_p_value", change.p_middle}};
}

Json gate_json(const LogGate& gate) {
  Json changes = json_list(gate.changes, change_json);
  return {{"file", gate.baseline},
          {"verdict_before", gate.verdict_before},
          {"became_inconsistent", gate.became_inconsistent},
          {"compared_by", !gate.compares() ? Json(nullptr) : Json(gate.by_means ? "means" : "units")},
          {"changes", std::move(changes)},
          {"missing_runs", gate.missing_runs},
          {"worse", gate.worse}};
}

bool lost_any(const CheckedLogs& logs) {
  return !not_judged(logs.analysis.evidence).empty() && (!compared(logs) || logs.gate->lost_more);
}

bool fails(const CheckedLogs& logs) {
  if (logs.gate && !logs.gate->worse.empty()) return true;
  return !compared(logs) && is_inconsistent(logs.analysis.judgement.word.verdict);
}

std::string junit_xml(const CheckedLogs& logs, double confidence) {
  const Judgement& j = logs.analysis.judgement;
  const bool failed = fails(logs);
  // What is wrong and was so before is no failure, and not passed.
  const auto against_baseline = [&](std::string says) {
    return fmt::format("{} (only what is worse than {} fails)", says, logs.gate->baseline);
  };
  const bool known = compared(logs) && is_inconsistent(j.word.verdict);
  std::vector<JunitCase> cases = {{"the covariance can be trusted",
                                   known ? against_baseline(log_answer(logs)) : log_answer(logs),
                                   failed && !compared(logs), known || j.word.verdict == Verdict::undecided}};
  if (logs.gate) {
    cases.push_back({"no worse than " + logs.gate->baseline, gate_sentence(*logs.gate),
                     !logs.gate->worse.empty(), logs.gate->worse.empty() && !compared(logs)});
  }
  if (const std::string lost = not_judged(logs.analysis.evidence); !lost.empty())
    cases.push_back({"every run and row is judged", lost_any(logs) ? lost : against_baseline(lost),
                     lost_any(logs), !lost_any(logs)});
  for (const NamedTest& test : j.tests) {
    const bool rejects = test.adjusted <= 1.0 - confidence;
    cases.push_back({test.name,
                     fmt::format("{}; {}, adjusted {}", test.says, p_value_statement(test.p_value),
                                 p_value_text(test.adjusted)),
                     rejects && failed && !compared(logs), std::isnan(test.p_value)});
    if (cases.back().skipped) cases.back().says = test.says;
    if (rejects && compared(logs)) {
      cases.back().skipped = true;
      cases.back().says = against_baseline(cases.back().says);
    }
  }
  const auto count = [&](bool JunitCase::*what) { return std::ranges::count(cases, true, what); };
  std::string xml = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"credence check {}\" tests=\"{}\" "
      "failures=\"{}\" errors=\"0\" skipped=\"{}\">\n",
      escape_html(logs.name), cases.size(), count(&JunitCase::failed), count(&JunitCase::skipped));
  for (const JunitCase& c : cases) xml += junit_case(c);
  return xml + "</testsuite>\n";
}

namespace {

/// The same Markdown, in which nothing of a name is HTML, a link, emphasis, code, or a character that hides.
std::string without_markup(std::string_view markdown) {
  std::string text;
  while (!markdown.empty()) {
    const std::size_t length = markdown.find('\n');
    for (const char c : printable_line(markdown.substr(0, length))) {
      const bool of_address = c == '/' && text.ends_with(':');  // as of http:, which is a link by itself
      if (std::string_view("[]*`~").find(c) != std::string_view::npos) text += '\\';
      text += c == '<' ? "&lt;" : c == '&' ? "&amp;" : of_address ? "&#47;" : std::string(1, c);
    }
    if (length == std::string_view::npos) break;
    text += '\n';
    markdown.remove_prefix(length + 1);
  }
  return text;
}

}  // namespace

std::string markdown_summary(const CheckedLogs& logs) {
  const Judgement& j = logs.analysis.judgement;
  constexpr std::size_t kBlocks = 12;
  std::string text = fmt::format("## {}: {}\n\n{}.\n\n", printable_line(logs.name), to_string(j.word.verdict),
                                 log_answer(logs));
  const ReportTable verdicts = log_verdicts(logs, kBlocks);
  const auto row = [&](const auto& cells, const auto& of) {
    for (const auto& cell : cells) {
      text += "| ";
      for (const char c : std::string(of(cell))) text += c == '|' ? std::string("\\|") : std::string(1, c);
      text += ' ';
    }
    text += "|\n";
  };
  if (!verdicts.rows.empty()) {
    row(verdicts.columns, [](const TableColumn& c) { return c.title; });
    row(verdicts.columns, [](const TableColumn& c) { return c.align == ColumnAlign::words ? ":--" : "--:"; });
  }
  for (const auto& cells : verdicts.rows) row(cells, [](const TableCell& cell) { return cell.text; });
  text += "\n";
  const auto bullets = [&](const std::vector<std::string>& sentences) {
    for (const std::string& sentence : sentences) text += "- " + sentence + "\n";
  };
  if (logs.gate) {
    text += gate_sentence(*logs.gate) + "\n\n";
  }
  if (const std::string lost = not_judged(logs.analysis.evidence); !lost.empty()) bullets({lost + "."});
  bullets(logs.advice());
  bullets(logs.factor_sentences());
  bullets(logs.all_remarks());
  return without_markup(text);
}

}  // namespace credence::internal
