#include "reports/document/study/study_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <span>

#include "core/number_text.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study/judgement_report.h"
#include "reports/document/study/step_csv.h"
#include "reports/document/study/study_json.h"
#include "reports/document/verdict_text.h"
#include "reports/figures/study_figures.h"

namespace credence::internal {
namespace {

template <class Predicate>
bool any_of(std::span<const ReportedStudy> studies, Predicate holds) {
  return std::ranges::any_of(studies, holds, &ReportedStudy::analysis);
}

// ---- The answer and the verdicts

TableCell failures_cell(const StudyStatistics& s) {
  if (s.failures.empty()) return {0};
  const std::int64_t threw = s.count(Outcome::threw);
  return {fmt::format("{} ({} diverged, {} not positive definite{})", s.failures.size(),
                      s.count(Outcome::diverged), s.count(Outcome::not_positive_definite),
                      threw > 0 ? fmt::format(", {} threw", threw) : ""),
          CellTone::alarm};
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

/// Whether the verdict is of the innovation covariance, and nothing is said of P.
bool is_of_innovation_alone(const StudyAnalysis& a) { return !a.stop && a.word.of_S_alone; }

bool is_inflated(const StudyAnalysis& a) { return a.scenario.filter.inflation != FilterInflation::none; }

std::span<const BlockVerdict> blocks_of(const StudyAnalysis& a) {
  if (!a.judgement) return {};
  return a.judgement->blocks;
}

/// Whether the answer is a word alone: that of a stop rule, where the word over all tests is another one.
bool says_no_more(const StudyAnalysis& a) {
  return overall_verdict(a) != a.word.verdict || a.word.says.empty();
}

/// What is wrong with one study, and its pose where that is hidden in the whole.
std::string fault_clause(const StudyAnalysis& a) {
  if (says_no_more(a)) {
    return fmt::format("{} is {}", a.scenario.name, to_string(overall_verdict(a)));
  }
  std::string clause = fmt::format("{} is {}", a.scenario.name, word_clause(a.word, a.nees, blocks_of(a)));
  if (a.vehicle_nees && is_unsafe(a.vehicle_nees->verdict)) {
    clause += fmt::format("; NEES of the pose {}", against_expected(*a.vehicle_nees));
  }
  return clause;
}

std::string names_of(const std::vector<const StudyAnalysis*>& studies) {
  std::vector<std::string> all;
  all.reserve(studies.size());
  for (const StudyAnalysis* a : studies) all.push_back(a->scenario.name);
  return fmt::format("{}", fmt::join(all, ", "));
}

/// The answer of one study that can be trusted.
std::string single_answer(const StudyAnalysis& a) {
  switch (overall_verdict(a)) {
    case Verdict::pessimistic:
      if (is_of_innovation_alone(a)) {
        return fmt::format("The innovation covariance S is larger than the innovations: {}", fault_clause(a));
      }
      return fmt::format("This covariance is larger than the errors{}: {}",
                         is_inflated(a) ? ", as inflation makes it" : "", fault_clause(a));
    case Verdict::not_gaussian: return fmt::format("{}: {}", a.scenario.name, a.word.says);
    case Verdict::undecided: {
      const std::string of_stop = contradiction_of_stop(a);
      const std::string& reason = !of_stop.empty() ? of_stop
                                  : a.judgement    ? a.judgement->nees.reason
                                                   : a.nees.reason;
      return fmt::format("{} is undecided{}", a.scenario.name, reason.empty() ? "" : ": " + reason);
    }
    default:
      return "No evidence that this covariance is wrong" + (a.judgement ? power_clause(*a.judgement) : "");
  }
}

std::vector<std::string> explanation_notes(std::span<const ReportedStudy> studies) {
  const double confidence = studies.empty() ? 0.95 : studies.front().analysis.scenario.study.confidence;
  std::vector<std::string> notes = {
      "factor on P: the true covariance over the claimed one, on average over steps, with its interval. "
      "NEES: squared error in units of P, mean of expected; NIS: of the innovation in units of S.",
      "consistent: no evidence against P. optimistic: errors are larger than P says; do not trust it. "
      "pessimistic: smaller somewhere, larger nowhere. mixed: larger here, smaller there; do not trust it.",
      fmt::format("The verdict of a consistent filter is wrong with at most {:g} % probability, over NEES, "
                  "NIS and all blocks and steps together.",
                  100.0 * (1.0 - confidence))};
  if (any_of(studies, [](const StudyAnalysis& a) { return overall_verdict(a) == Verdict::not_gaussian; })) {
    notes.push_back("not Gaussian: P is right, and the errors have heavier tails than a Gaussian law.");
  }
  if (any_of(studies, [](const StudyAnalysis& a) { return a.stop.has_value(); })) {
    notes.push_back("With a stop rule the verdict is that of the rule, unless other tests contradict it.");
  }
  return notes;
}

ReportAnswer answer_of_verdicts(std::span<const ReportedStudy> studies) {
  std::vector<const StudyAnalysis*> unsafe, large_P, large_S, undecided;
  for (const auto& [a, trace, description] : studies) {
    const Verdict verdict = overall_verdict(a);
    if (is_unsafe(verdict)) unsafe.push_back(&a);
    if (verdict == Verdict::pessimistic) (is_of_innovation_alone(a) ? large_S : large_P).push_back(&a);
    if (verdict == Verdict::undecided) undecided.push_back(&a);
  }
  const std::size_t n = studies.size();
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
                unsafe.size() <= kExplained ? fmt::format("{}", fmt::join(faults, "; ")) : names_of(unsafe))};
  }
  if (n == 1)
    return {verdict_cell(overall_verdict(studies.front().analysis)).tone,
            single_answer(studies.front().analysis)};
  if (!undecided.empty()) {
    return {CellTone::caution,
            fmt::format("{} of {} filters undecided: {}", undecided.size(), n, names_of(undecided))};
  }
  std::string rest;
  if (!large_P.empty()) rest += fmt::format("; larger than necessary: {}", names_of(large_P));
  if (!large_S.empty()) rest += fmt::format("; S alone larger than necessary: {}", names_of(large_S));
  return {rest.empty() ? CellTone::good : CellTone::caution,
          fmt::format("No evidence that any of these {} covariances is too small{}", n, rest)};
}

/// The verdicts are of the steps before a run failed: that it did, is no less a fault.
ReportAnswer study_answer(std::span<const ReportedStudy> studies) {
  ReportAnswer answer = answer_of_verdicts(studies);
  std::int64_t failed = 0, runs = 0;
  for (const auto& [a, trace, description] : studies) {
    failed += std::ssize(a.statistics.failures);
    runs += a.statistics.runs;
  }
  if (failed == 0) return answer;
  if (failed == runs) {
    return {CellTone::alarm,
            runs == 1 ? "The only run failed" : fmt::format("No run finished: all {} failed", runs)};
  }
  answer.text += "; " + failed_text(failed, runs);
  if (answer.tone != CellTone::alarm) answer.tone = CellTone::caution;
  return answer;
}

bool has_poses(std::span<const ReportedStudy> studies) {
  return any_of(studies, [](const StudyAnalysis& a) { return a.vehicle_nees.has_value(); });
}

ReportTable verdict_table(std::span<const ReportedStudy> studies, const ReportAnswer& answer) {
  using enum ColumnAlign;
  ReportTable table{.title = answer.text,
                    .columns = {{"study", words},
                                {"verdict", words},
                                {"factor on P", words},
                                {"NEES", words},
                                {"of the pose", words},
                                {"NIS", words},
                                {"inflation", words},
                                {"runs"},
                                {"failed"}}};
  for (const auto& [a, trace, description] : studies) {
    table.add({fmt::format("{}{}", a.scenario.name, a.complete ? "" : " (interrupted)"),
               verdict_cell(overall_verdict(a)), factor_text(a.nees), against_expected(a.nees), pose_cell(a),
               against_expected(a.nis), filter_text(a.scenario.filter), a.statistics.runs,
               failures_cell(a.statistics)});
    if (!a.word.says.empty() && !a.stop)
      table.notes.push_back(word_sentence(a.scenario.name, a.word, a.nees, blocks_of(a)));
    if (a.judgement && !a.stop && a.word.verdict == Verdict::consistent) {
      if (std::string proof = proof_sentence(*a.judgement); !proof.empty())
        table.notes.push_back(fmt::format("{}: {}", a.scenario.name, proof));
    }
    if (const std::string open = not_converged_sentence(a.statistics.not_converged, a.statistics.runs);
        !open.empty()) {
      table.notes.push_back(fmt::format("{}: {}", a.scenario.name, open));
    }
  }
  for (std::string& note : explanation_notes(studies)) table.notes.push_back(std::move(note));
  constexpr std::ptrdiff_t kPose = 4;
  if (!has_poses(studies)) table.remove_column(kPose);
  return table;
}

// ---- The page

/// A file name for every study: its name reduced to letters, digits, '-' and '_', with a number if repeated,
/// or if it were that of the run of another (NAME-run.csv).
std::vector<std::string> file_names(std::span<const ReportedStudy> studies) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const ReportedStudy& study : studies) {
    const std::string name = plain_name(study.analysis.scenario.name, "study");
    std::string unique = name;
    for (int i = 2; taken.contains(unique) || taken.contains(unique + "-run"); ++i) {
      unique = fmt::format("{}-{}", name, i);
    }
    taken.insert({unique, unique + "-run"});
    names.push_back(unique);
  }
  return names;
}

/// With how a run that is lost can be seen.
std::vector<std::string> study_advice(const Judgement& judgement) {
  std::vector<std::string> sentences = advice_sentences(judgement);
  if (!judgement.lost.runs.empty()) {
    sentences.push_back(
        fmt::format("The same command with --only-run {} plays such a run again, step by step.",
                    judgement.lost.runs.front().run));
  }
  return sentences;
}

void add_failures(Document& document, const StudyAnalysis& a) {
  if (a.statistics.failures.empty()) return;
  constexpr std::size_t kShown = 20;
  std::vector<std::string> items;
  for (const RunFailure& f : a.statistics.failures) {
    if (items.size() == kShown) {
      items.push_back(fmt::format("and {} more, all in the JSON", a.statistics.failures.size() - kShown));
      break;
    }
    items.push_back(fmt::format("run {} at step {}: {}", f.run, f.step, to_string(f.outcome)));
  }
  const auto failed = std::ssize(a.statistics.failures);
  document.callout(
      CellTone::alarm,
      fmt::format("{}. {}. {} can be replayed alone with --only-run.",
                  a.statistics.runs == 1 ? "The only run failed" : failed_text(failed, a.statistics.runs),
                  what_failed_count_in(failed, a.statistics.runs), failed == 1 ? "It" : "Each"));
  document.bullets(items);
}

/// For who wants the numbers behind the words.
void add_statistics(Document& document, const StudyAnalysis& a) {
  std::vector<std::string> sentences = {verdict_sentence("NEES", a.nees), verdict_sentence("NIS", a.nis)};
  if (a.vehicle_nees) sentences.push_back(verdict_sentence("NEES of the pose alone", *a.vehicle_nees));
  if (std::string exact = exact_sentence(a); !exact.empty()) sentences.push_back(std::move(exact));
  document.bullets(sentences);
  if (!a.judgement) return;
  document.bullets(statistics_sentences(*a.judgement));
  document.table(tests_table(*a.judgement));
  if (!a.judgement->accuracy.empty()) {
    document.table(accuracy_table(*a.judgement, a.bound ? &*a.bound : nullptr));
  }
}

/// "9 judged of 15 dimensions": those that NEES has at any step, where a filter holds more.
std::string state_text(const StudyAnalysis& a) {
  double most = 0.0;
  for (const StepTest& step : a.nees.steps) {
    if (step.has_data()) most = std::max(most, step.total_dof / static_cast<double>(step.count));
  }
  const auto judged = static_cast<Index>(std::lround(most));
  if (judged == 0) return fmt::format("{} dimensions", a.state_dim);
  return judged < a.state_dim ? fmt::format("{} judged of {} dimensions", judged, a.state_dim)
                              : fmt::format("{} dimensions judged", judged);
}

/// Which run is drawn, where it is not the first, or that none is.
std::string drawn_sentence(const StudyAnalysis& a, const std::optional<RunTrace>& trace) {
  const std::int64_t run = run_to_draw(a);
  if (!trace)
    return fmt::format("Run {} is not drawn: the covariances of all its steps take more than 2 GB.", run);
  const bool lost = a.judgement && !a.judgement->lost.runs.empty();
  const bool failed = std::ranges::count(a.statistics.failures, run, &RunFailure::run) > 0;
  if (trace->run != run || (!lost && !failed)) return {};
  return fmt::format("Run {} is drawn, which {}.", run, lost ? "left P behind" : "failed");
}

void add_study(Document& document, const ReportedStudy& study, const std::string& name) {
  const StudyAnalysis& a = study.analysis;
  if (!study.description.empty()) document.paragraph(study.description);
  document.facts(
      {{"world", world_text(a.scenario)},
       {"inflation", filter_text(a.scenario.filter)},
       {"runs",
        fmt::format("{}{} of {} steps, seed {}", a.statistics.runs,
                    a.complete ? "" : fmt::format(" (interrupted; {} were asked for)", a.scenario.study.runs),
                    a.scenario.study.steps, a.scenario.study.seed)},
       {"state", state_text(a)}});
  if (a.stop) document.callout(verdict_cell(overall_verdict(a)).tone, stop_sentence(a));
  if (a.judgement) document.bullets(study_advice(*a.judgement));
  add_failures(document, a);
  if (std::string open = not_converged_sentence(a.statistics.not_converged, a.statistics.runs);
      !open.empty()) {
    document.callout(CellTone::caution, std::move(open));
  }
  if (std::string why = drawn_sentence(a, study.trace); !why.empty()) document.paragraph(why);
  document.figures(study_figures(name, a, study.trace));
  document.folded("Statistics", [&] {
    add_statistics(document, a);
    if (a.judgement) document.figure(evidence_figure(name, *a.judgement));
  });
  document.folded("Settings", [&] { document.verbatim(canonical_toml(a.scenario)); });
  document.link("every step as CSV", name + ".csv");
  if (study.trace) document.link(fmt::format("run {} as CSV", study.trace->run), name + "-run.csv");
}

/// What else the heading of a study says, behind its verdict.
std::string line_of(const StudyAnalysis& a) {
  if (says_no_more(a)) return {};
  const std::string clause = word_clause(a.word, a.nees, blocks_of(a));
  const std::string verdict(to_string(overall_verdict(a)));
  return clause.starts_with(verdict + " ") ? clause.substr(verdict.size() + 1) : clause;
}

/// Which studies are shown unfolded: all of few; of many the first one that cannot be trusted.
std::vector<bool> unfolded(std::span<const ReportedStudy> studies) {
  constexpr std::size_t kFew = 2;
  std::vector<bool> open(studies.size(), studies.size() <= kFew);
  for (std::size_t i = 0; i < studies.size() && studies.size() > kFew; ++i) {
    if (verdict_cell(overall_verdict(studies[i].analysis)).tone != CellTone::alarm) continue;
    open[i] = true;
    break;
  }
  return open;
}

std::string seeds_of(std::span<const ReportedStudy> studies) {
  std::set<std::string> seeds;
  for (const ReportedStudy& study : studies) {
    seeds.insert(fmt::format("{}", study.analysis.scenario.study.seed));
  }
  return fmt::format("{}", fmt::join(seeds, ", "));
}

std::string title_of(std::span<const ReportedStudy> studies) {
  return studies.size() == 1 ? studies.front().analysis.scenario.name : "Can these covariances be trusted?";
}

/// The verdicts, and of a single study what to do about it.
void show_on_terminal(Document& document, std::span<const ReportedStudy> studies,
                      const ReportTable& verdicts) {
  document.brief.emplace_back(verdicts);
  for (const auto& [a, trace, description] : studies) {
    if (a.stop) document.brief.emplace_back(a.scenario.name + ": " + stop_sentence(a));
  }
  const StudyAnalysis& a = studies.front().analysis;
  if (studies.size() > 1 || !a.judgement) return;
  document.show(study_advice(*a.judgement));
  document.show(statistics_sentences(*a.judgement));
  if (std::string exact = exact_sentence(a); !exact.empty()) document.brief.emplace_back(std::move(exact));
}

void add_verdicts(Document& document, std::span<const ReportedStudy> studies, ReportTable verdicts,
                  const std::vector<std::string>& anchors) {
  verdicts.title = "One row for each study";
  if (has_poses(studies))
    verdicts.title += "; the pose has a column of its own, since a sum over a large map can hide it";
  for (std::size_t i = 0; i < studies.size(); ++i) verdicts.rows[i].front().link = "#" + anchors[i];
  verdicts.notes = explanation_notes(studies);
  document.table(std::move(verdicts));
}

}  // namespace

std::int64_t run_to_draw(const StudyAnalysis& a) {
  if (a.judgement && !a.judgement->lost.runs.empty()) return a.judgement->lost.runs.front().run;
  const auto& failures = a.statistics.failures;
  const auto drawable = std::ranges::find_if(failures, [](const RunFailure& f) { return f.step > 1; });
  return drawable == failures.end() ? 0 : drawable->run;
}

Document study_document(std::vector<ReportedStudy> given) {
  const auto shared = std::make_shared<const std::vector<ReportedStudy>>(std::move(given));
  const std::vector<ReportedStudy>& studies = *shared;
  Document document(title_of(studies), "Monte Carlo consistency of simulated filters");
  document.answer = study_answer(studies);
  ReportTable verdicts = verdict_table(studies, document.answer);
  document.json = [shared] { return studies_json(*shared); };
  document.sources = {{"seed", seeds_of(studies)}};
  for (const auto& [a, trace, description] : studies) {
    if (!description.empty()) document.descriptions.emplace_back(a.scenario.name, description);
  }
  show_on_terminal(document, studies, verdicts);

  const std::vector<std::string> names = file_names(studies);
  const std::vector<bool> open = unfolded(studies);
  document.section("Verdicts");
  std::vector<std::string> anchors;
  anchors.reserve(studies.size());
  for (const auto& [a, trace, description] : studies) anchors.push_back(document.reserve(a.scenario.name));
  add_verdicts(document, studies, std::move(verdicts), anchors);
  for (std::size_t i = 0; i < studies.size(); ++i) {
    const StudyAnalysis& a = studies[i].analysis;
    document.folded_section(
        a.scenario.name, verdict_cell(overall_verdict(a)), line_of(a), open[i],
        [&] { add_study(document, studies[i], names[i]); }, anchors[i]);
    document.file(names[i] + ".csv",
                  [shared, i](const auto& target) { write_study_csv(target, (*shared)[i].analysis); });
    if (!studies[i].trace) continue;
    document.file(names[i] + "-run.csv",
                  [shared, i](const auto& target) { write_trace_csv(target, *(*shared)[i].trace); });
  }
  return document;
}

}  // namespace credence::internal
