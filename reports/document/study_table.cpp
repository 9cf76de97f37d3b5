#include "reports/document/study_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "reports/document/judgement_report.h"
#include "reports/render/interval_text.h"
#include "reports/render/number_text.h"

namespace credence {
namespace {

TableCell failures_cell(const StudyStatistics& s) {
  if (s.failures.empty()) return {0};
  return {fmt::format("{} ({} diverged, {} not positive definite)", s.failures.size(),
                      s.count(Outcome::diverged), s.count(Outcome::not_positive_definite)),
          CellTone::alarm};
}

}  // namespace

std::string word_clause(const Word& word, const ConsistencyVerdict& nees) {
  std::string clause = word.says;
  const bool one_factor = nees.factor.reason.empty() && (nees.factor.lower > 1.0 || nees.factor.upper < 1.0);
  if (one_factor && word.verdict != Verdict::mixed) {
    clause += fmt::format("; times {} on P the mean NEES would be right", number_text(nees.factor.mean, 3));
  }
  return clause;
}

std::string filter_text(const FilterSettings& filter) {
  std::string text(to_string(filter.inflation));
  if (filter.inflation == FilterInflation::full || filter.inflation == FilterInflation::map) {
    text += fmt::format(", {}", to_string(filter.solution));
  }
  if (filter.inflation == FilterInflation::rank) {
    text += fmt::format(" {} ({})", filter.inflation_rank, to_string(filter.inflation_range));
  }
  if (filter.process_scale != 1.0) text += fmt::format(", Q × {:g}", filter.process_scale);
  if (filter.measurement_scale != 1.0) text += fmt::format(", R × {:g}", filter.measurement_scale);
  return text;
}

TableCell verdict_cell(Verdict verdict) {
  const CellTone tone = verdict == Verdict::consistent                                ? CellTone::good
                        : verdict == Verdict::optimistic || verdict == Verdict::mixed ? CellTone::alarm
                                                                                      : CellTone::caution;
  return {std::string(to_string(verdict)), tone};
}

namespace {

bool is_unsafe(Verdict verdict) { return verdict == Verdict::optimistic || verdict == Verdict::mixed; }

/// "27.8 of 22.1".
std::string against_expected(const ConsistencyVerdict& v) {
  if (v.count == 0) return "–";
  return fmt::format("{} of {}", number_text(v.mean, 4), number_text(v.expected, 4));
}

std::string factor_text(const ConsistencyVerdict& nees) {
  const MeanInterval& f = nees.factor;
  if (!f.reason.empty()) return "–";
  return interval_text(f.mean, f.lower, f.upper);
}

/// What a robot drives by, coloured as the sum over the map may hide it.
TableCell pose_cell(const StudyAnalysis& a) {
  if (!a.vehicle_nees) return "–";
  const Verdict verdict = a.vehicle_nees->verdict;
  return {against_expected(*a.vehicle_nees), is_unsafe(verdict) ? CellTone::alarm : CellTone::plain};
}

bool is_inflated(const StudyAnalysis& a) { return a.scenario.filter.inflation != FilterInflation::none; }

/// What is wrong with one study, and its pose where that is hidden in the whole.
std::string fault_clause(const StudyAnalysis& a) {
  if (a.stop || a.word.says.empty()) {
    return fmt::format("{} is {}", a.scenario.name, to_string(overall_verdict(a)));
  }
  std::string clause = fmt::format("{} is {}", a.scenario.name, word_clause(a.word, a.nees));
  if (a.vehicle_nees && is_unsafe(a.vehicle_nees->verdict)) {
    clause += fmt::format("; NEES of the pose {}", against_expected(*a.vehicle_nees));
  }
  return clause;
}

std::string names(const std::vector<const StudyAnalysis*>& studies) {
  std::vector<std::string> all;
  all.reserve(studies.size());
  for (const StudyAnalysis* a : studies) all.push_back(a->scenario.name);
  return fmt::format("{}", fmt::join(all, ", "));
}

/// The answer of one study that can be trusted.
std::string single_answer(const StudyAnalysis& a) {
  switch (overall_verdict(a)) {
    case Verdict::pessimistic:
      return fmt::format("This covariance is larger than the errors{}: {}",
                         is_inflated(a) ? ", as inflation makes it" : "", fault_clause(a));
    case Verdict::not_gaussian:
      return fmt::format("{}: {}", a.scenario.name, a.word.says);
    case Verdict::undecided:
      return fmt::format("{} is undecided{}", a.scenario.name,
                         a.nees.reason.empty() ? "" : ": " + a.nees.reason);
    default:
      return "Nothing says that this covariance is wrong";
  }
}

}  // namespace

std::string word_sentence(const std::string& name, const Word& word, const ConsistencyVerdict& nees) {
  return fmt::format("{}: {}.", name, word_clause(word, nees));
}

ReportAnswer study_answer(std::span<const StudyAnalysis> analyses) {
  std::vector<const StudyAnalysis*> unsafe, pessimistic, undecided;
  for (const StudyAnalysis& a : analyses) {
    const Verdict verdict = overall_verdict(a);
    if (is_unsafe(verdict)) unsafe.push_back(&a);
    if (verdict == Verdict::pessimistic) pessimistic.push_back(&a);
    if (verdict == Verdict::undecided) undecided.push_back(&a);
  }
  const std::size_t n = analyses.size();
  constexpr std::size_t kExplained = 2;
  if (!unsafe.empty()) {
    std::vector<std::string> faults;
    faults.reserve(unsafe.size());
    for (const StudyAnalysis* a : unsafe) faults.push_back(fault_clause(*a));
    const std::string whose =
        n == 1 ? "This filter cannot" : fmt::format("{} of {} filters cannot", unsafe.size(), n);
    return {CellTone::alarm,
            fmt::format(
                "{} be trusted: {}", whose,
                unsafe.size() <= kExplained ? fmt::format("{}", fmt::join(faults, "; ")) : names(unsafe))};
  }
  if (n == 1) return {verdict_cell(overall_verdict(analyses.front())).tone, single_answer(analyses.front())};
  if (!undecided.empty()) {
    return {CellTone::caution,
            fmt::format("{} of {} filters undecided: {}", undecided.size(), n, names(undecided))};
  }
  const std::string rest =
      pessimistic.empty() ? "" : fmt::format("; larger than need be: {}", names(pessimistic));
  return {pessimistic.empty() ? CellTone::good : CellTone::caution,
          fmt::format("Nothing says that any of these {} covariances is too small{}", n, rest)};
}

ReportTable verdict_table(std::span<const StudyAnalysis> analyses) {
  using enum ColumnAlign;
  ReportTable table{.title = study_answer(analyses).text,
                    .columns = {{"study", words},
                                {"verdict", words},
                                {"factor on P", words},
                                {"NEES", words},
                                {"of the pose", words},
                                {"NIS", words},
                                {"inflation", words},
                                {"runs"},
                                {"failed"}},
                    .rows = {},
                    .notes = {}};
  for (const StudyAnalysis& a : analyses) {
    table.add({fmt::format("{}{}", a.scenario.name, a.complete ? "" : " (interrupted)"),
               verdict_cell(overall_verdict(a)), factor_text(a.nees), against_expected(a.nees), pose_cell(a),
               against_expected(a.nis), filter_text(a.scenario.filter), a.statistics.runs,
               failures_cell(a.statistics)});
    if (!a.word.says.empty() && !a.stop)
      table.notes.push_back(word_sentence(a.scenario.name, a.word, a.nees));
    if (a.judgement && !a.stop && a.word.verdict == Verdict::consistent) {
      if (std::string proof = proof_sentence(*a.judgement); !proof.empty())
        table.notes.push_back(fmt::format("{}: {}", a.scenario.name, proof));
    }
  }
  for (std::string& note : explanation_notes(analyses)) table.notes.push_back(std::move(note));
  return table;
}

std::vector<std::string> explanation_notes(std::span<const StudyAnalysis> analyses) {
  const double confidence = analyses.empty() ? 0.95 : analyses.front().scenario.study.confidence;
  std::vector<std::string> notes = {
      "factor on P: the true covariance over the claimed one, on average over steps, with its interval. "
      "NEES: "
      "squared error in units of P, mean of expected; NIS: of the innovation in units of S.",
      "consistent: nothing speaks against P. optimistic: errors are larger than P says; do not trust it. "
      "pessimistic: smaller everywhere. mixed: larger here, smaller there; do not trust it.",
      fmt::format(
          "The verdict of a consistent filter is wrong with at most {:g} % probability, over NEES, NIS "
          "and all blocks and steps together.",
          100.0 * (1.0 - confidence))};
  if (std::ranges::any_of(
          analyses, [](const StudyAnalysis& a) { return overall_verdict(a) == Verdict::not_gaussian; })) {
    notes.push_back("not Gaussian: P is right, and the errors have heavier tails than a Gaussian law.");
  }
  if (std::ranges::any_of(analyses, [](const StudyAnalysis& a) { return a.stop.has_value(); })) {
    notes.push_back("Of a study with a stop rule the verdict is that of the rule.");
  }
  return notes;
}

}  // namespace credence
