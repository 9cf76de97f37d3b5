#include "reports/document/study_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/judgement_report.h"
#include "reports/document/study_csv.h"
#include "reports/document/study_table.h"
#include "reports/figures/draw_figures.h"
#include "reports/figures/study_figures.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"
#include "reports/render/number_text.h"

namespace credence {
namespace {

/// A file name for every study: its name reduced to letters, digits, '-' and '_', with a number if repeated.
std::vector<std::string> file_names(std::span<const ReportedStudy> studies) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const ReportedStudy& study : studies) {
    std::string name;
    for (const char c : study.analysis.scenario.name) {
      const bool plain =
          (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
      name += plain ? c : '_';
    }
    if (name.empty()) name = "study";
    std::string unique = name;
    for (int i = 2; !taken.insert(unique).second; ++i) unique = fmt::format("{}-{}", name, i);
    names.push_back(unique);
  }
  return names;
}

void add_failures(HtmlPage& page, const StudyAnalysis& a) {
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
  page.callout(
      CellTone::alarm,
      fmt::format("{} of {} runs failed. They count up to the step before, and each can be replayed alone "
                  "with --only-run.",
                  a.statistics.failures.size(), a.statistics.runs));
  page.bullets(items);
}

/// For who wants the numbers behind the words.
void add_statistics(HtmlPage& page, const StudyAnalysis& a) {
  std::vector<std::string> sentences = {verdict_sentence("NEES", a.nees), verdict_sentence("NIS", a.nis)};
  if (a.vehicle_nees) sentences.push_back(verdict_sentence("NEES of the pose alone", *a.vehicle_nees));
  if (std::string exact = exact_sentence(a); !exact.empty()) sentences.push_back(std::move(exact));
  page.bullets(sentences);
  if (!a.judgement) return;
  page.bullets(statistics_sentences(*a.judgement));
  page.table(tests_table(*a.judgement));
  if (!a.judgement->accuracy.empty()) {
    page.table(accuracy_table(*a.judgement, a.bound ? &*a.bound : nullptr));
  }
}

/// A study's figures as they were drawn.
struct DrawnFigures {
  std::span<const Figure> figures;
  std::span<const Drawing> drawings;
};

void add_study(HtmlPage& page, const ReportedStudy& study, const std::string& name, const DrawnFigures& drawn,
               const std::filesystem::path& directory) {
  const StudyAnalysis& a = study.analysis;
  if (!study.description.empty()) page.paragraph(study.description);
  page.facts({{"world", world_text(a.scenario)},
              {"inflation", filter_text(a.scenario.filter)},
              {"runs",
               fmt::format("{}{} of {} steps, seed {}", a.statistics.runs, a.complete ? "" : " (interrupted)",
                           a.scenario.study.steps, a.scenario.study.seed)},
              {"state", fmt::format("{} dimensions", a.state_dim)}});
  if (a.stop) page.callout(verdict_cell(a.stop->verdict).tone, stop_sentence(a));
  if (a.judgement) {
    const std::vector<std::string> advice = advice_sentences(*a.judgement);
    if (!advice.empty()) page.bullets(advice);
  }
  add_failures(page, a);
  const auto is_evidence = [](const Figure& figure) { return figure.name.ends_with(kEvidenceSuffix); };
  for (std::size_t i = 0; i < drawn.figures.size(); ++i) {
    if (!is_evidence(drawn.figures[i])) page.figure(drawn.figures[i], drawn.drawings[i], directory);
  }
  page.folded("Statistics", [&] {
    add_statistics(page, a);
    for (std::size_t i = 0; i < drawn.figures.size(); ++i) {
      if (is_evidence(drawn.figures[i])) page.figure(drawn.figures[i], drawn.drawings[i], directory);
    }
  });
  page.folded("Settings", [&] { page.verbatim(canonical_toml(a.scenario)); });
  page.link("every step as CSV", name + ".csv");
  page.link("run 0 as CSV", name + "-run.csv");
}

/// What else the heading of a study says, behind its verdict.
std::string line_of(const StudyAnalysis& a) {
  if (a.stop || a.word.says.empty()) return {};
  const std::string clause = word_clause(a.word, a.nees);
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

}  // namespace

std::string verdict_sentence(const char* what, const ConsistencyVerdict& v) {
  if (v.verdict == Verdict::undecided) return fmt::format("{}: undecided, {}.", what, v.reason);
  return fmt::format(
      "{}: {}. The mean of {} over {} values would be accepted from {} to {}, around {} ({:g} % confidence, "
      "{}, "
      "{} tests); {} % of the steps lie outside their own bounds, where {} % are expected.",
      what, to_string(v.verdict), number_text(v.mean, 4), v.count, number_text(v.bounds.lower, 4),
      number_text(v.bounds.upper, 4), number_text(v.expected, 4), 100.0 * v.confidence,
      p_value_statement(v.p_value), v.tests, number_text(100.0 * v.share_outside, 3),
      number_text(100.0 * v.expected_share_outside, 3));
}

std::string report_title(std::span<const ReportedStudy> studies) {
  return studies.size() == 1 ? studies.front().analysis.scenario.name : "Can these covariances be trusted?";
}

void write_study_report(const ReportFolder& directory, const std::string& title,
                        std::span<const ReportedStudy> studies, const Provenance& provenance) {
  const std::vector<std::string> names = file_names(studies);

  std::vector<Figure> figures;
  std::vector<std::size_t> first_figure;
  std::vector<StudyAnalysis> analyses;
  for (std::size_t i = 0; i < studies.size(); ++i) {
    first_figure.push_back(figures.size());
    for (Figure& figure : study_figures(names[i], studies[i].analysis, studies[i].trace)) {
      figures.push_back(std::move(figure));
    }
    analyses.push_back(studies[i].analysis);
  }
  first_figure.push_back(figures.size());
  const std::vector<Drawing> drawings = draw_all(figures, directory);

  HtmlPage page(title, "Monte Carlo consistency of simulated filters");
  const ReportAnswer answer = study_answer(analyses);
  page.answer(answer.tone, answer.text + ".");
  page.section("Verdicts");
  ReportTable verdicts = verdict_table(analyses);
  const bool has_pose =
      std::ranges::any_of(analyses, [](const StudyAnalysis& a) { return a.vehicle_nees.has_value(); });
  verdicts.title = "One row for each study";
  if (has_pose) verdicts.title += "; of the pose: what a robot drives by, which a sum over a map can hide";
  std::vector<std::string> anchors;
  for (std::size_t i = 0; i < studies.size(); ++i) {
    anchors.push_back(page.reserve(analyses[i].scenario.name));
    verdicts.rows[i].front().link = "#" + anchors.back();
  }
  verdicts.notes = explanation_notes(analyses);
  page.table(verdicts);
  const std::vector<bool> open = unfolded(studies);
  for (std::size_t i = 0; i < studies.size(); ++i) {
    write_study_csv(directory / (names[i] + ".csv"), studies[i].analysis);
    write_trace_csv(directory / (names[i] + "-run.csv"), studies[i].trace);
    const std::size_t first = first_figure[i], count = first_figure[i + 1] - first;
    const DrawnFigures drawn{std::span(figures).subspan(first, count),
                             std::span(drawings).subspan(first, count)};
    page.folded_section(
        analyses[i].scenario.name, verdict_cell(overall_verdict(analyses[i])), line_of(analyses[i]), open[i],
        [&] { add_study(page, studies[i], names[i], drawn, directory); }, anchors[i]);
  }
  page.provenance(provenance, {{"seed", seeds_of(studies)}});
  page.write(directory / "index.html");
}

}  // namespace credence
