#include "reports/document/study_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "reports/document/judgement_report.h"
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

std::string world_text(const Scenario& scenario) {
  const WorldSettings& world = scenario.world;
  const std::string anchors = world.anchors == 0
                                  ? "partially observable"
                                  : fmt::format("{} anchor{}", world.anchors, world.anchors == 1 ? "" : "s");
  const double seen = scenario.noise.detection_probability;
  return fmt::format("{}, {} landmark{}, {}{}", to_string(world.model), world.landmarks,
                     world.landmarks == 1 ? "" : "s", anchors,
                     seen < 1.0 ? fmt::format(", each measured with probability {:g}", seen) : "");
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
  return fmt::format("{} ({} … {})", number_text(f.mean, 3), number_text(f.lower, 3),
                     number_text(f.upper, 3));
}

/// The answer, before any number.
std::string answer(std::span<const StudyAnalysis> analyses) {
  std::vector<std::string> unsafe, undecided;
  for (const StudyAnalysis& a : analyses) {
    const Verdict verdict = overall_verdict(a);
    if (is_unsafe(verdict)) unsafe.push_back(a.scenario.name);
    if (verdict == Verdict::undecided) undecided.push_back(a.scenario.name);
  }
  const std::size_t n = analyses.size();
  if (!unsafe.empty()) {
    return fmt::format("{} of {} filter{} cannot be trusted: {}", unsafe.size(), n, n == 1 ? "" : "s",
                       fmt::join(unsafe, ", "));
  }
  if (!undecided.empty()) {
    return fmt::format("{} of {} filter{} undecided: {}", undecided.size(), n, n == 1 ? "" : "s",
                       fmt::join(undecided, ", "));
  }
  return n == 1 ? "Nothing says that this covariance is too small"
                : fmt::format("Nothing says that any of these {} covariances is too small", n);
}

}  // namespace

std::string word_sentence(const std::string& name, const Word& word, const ConsistencyVerdict& nees) {
  std::string sentence = fmt::format("{}: {}", name, word.says);
  const bool one_factor = nees.factor.reason.empty() && (nees.factor.lower > 1.0 || nees.factor.upper < 1.0);
  if (one_factor && word.verdict != Verdict::mixed) {
    sentence += fmt::format("; times {} on P the mean NEES would be right", number_text(nees.factor.mean, 3));
  }
  return sentence + ".";
}

ReportTable verdict_table(std::span<const StudyAnalysis> analyses) {
  using enum ColumnAlign;
  ReportTable table{.title = answer(analyses),
                    .columns = {{"study", words},
                                {"inflation", words},
                                {"runs"},
                                {"verdict", words},
                                {"factor on P", words},
                                {"NEES", words},
                                {"of the pose", words},
                                {"NIS", words},
                                {"failed runs"}},
                    .rows = {},
                    .notes = {}};
  for (const StudyAnalysis& a : analyses) {
    table.add({fmt::format("{}{}", a.scenario.name, a.complete ? "" : " (interrupted)"),
               filter_text(a.scenario.filter), a.statistics.runs, verdict_cell(overall_verdict(a)),
               factor_text(a.nees), against_expected(a.nees),
               a.vehicle_nees ? against_expected(*a.vehicle_nees) : "–", against_expected(a.nis),
               failures_cell(a.statistics)});
    if (!a.word.says.empty() && !a.stop)
      table.notes.push_back(word_sentence(a.scenario.name, a.word, a.nees));
    if (a.judgement && !a.stop && a.word.verdict == Verdict::consistent) {
      if (std::string proof = proof_sentence(*a.judgement); !proof.empty())
        table.notes.push_back(fmt::format("{}: {}", a.scenario.name, proof));
    }
  }
  const double confidence = analyses.empty() ? 0.95 : analyses.front().scenario.study.confidence;
  table.notes.insert(
      table.notes.end(),
      {"factor on P: the true covariance over the claimed one, on average over steps, with its interval. "
       "NEES: "
       "squared error in units of P, mean of expected; NIS: of the innovation in units of S.",
       "consistent: nothing speaks against P. optimistic: errors are larger than P says; do not trust it. "
       "pessimistic: smaller everywhere. mixed: larger here, smaller there; do not trust it.",
       fmt::format(
           "The verdict of a consistent filter is wrong with at most {:g} % probability, over NEES, NIS "
           "and all blocks and steps together.",
           100.0 * (1.0 - confidence))});
  if (std::ranges::any_of(
          analyses, [](const StudyAnalysis& a) { return overall_verdict(a) == Verdict::not_gaussian; })) {
    table.notes.push_back("not Gaussian: P is right, and the errors have heavier tails than a Gaussian law.");
  }
  if (std::ranges::any_of(analyses, [](const StudyAnalysis& a) { return a.stop.has_value(); })) {
    table.notes.push_back("Of a study with a stop rule the verdict is that of the rule.");
  }
  return table;
}

}  // namespace credence
