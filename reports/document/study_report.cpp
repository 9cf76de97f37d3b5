#include "reports/document/study_report.h"

#include <fmt/format.h>

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

void add_study(HtmlPage& page, const ReportedStudy& study, const std::string& name,
               std::span<const Figure> figures, std::span<const Drawing> drawings,
               const std::filesystem::path& directory) {
  const StudyAnalysis& a = study.analysis;
  page.section(a.scenario.name);
  page.facts({{"world", world_text(a.scenario)},
              {"inflation", filter_text(a.scenario.filter)},
              {"runs", fmt::format("{}{}", a.statistics.runs, a.complete ? "" : " (interrupted)")},
              {"steps", fmt::format("{}", a.scenario.study.steps)},
              {"seed", fmt::format("{}", a.scenario.study.seed)},
              {"state", fmt::format("{} dimensions", a.state_dim)}});
  page.paragraph(verdict_sentence("NEES", a.nees));
  page.paragraph(verdict_sentence("NIS", a.nis));
  if (a.vehicle_nees) page.paragraph(verdict_sentence("NEES of the pose alone", *a.vehicle_nees));
  if (a.stop) page.callout(verdict_cell(a.stop->verdict).tone, stop_sentence(a));
  if (a.judgement) page.bullets(advice_sentences(*a.judgement));
  add_failures(page, a);
  for (std::size_t i = 0; i < figures.size(); ++i) page.figure(figures[i], drawings[i], directory);
  if (a.judgement) page.table(tests_table(*a.judgement));
  page.link("every step as CSV", name + ".csv");
  page.subsection("Settings");
  page.verbatim(canonical_toml(a.scenario));
}

}  // namespace

std::string verdict_sentence(const char* what, const ConsistencyVerdict& v) {
  if (v.verdict == Verdict::undecided) return fmt::format("{}: undecided, {}.", what, v.reason);
  return fmt::format(
      "{}: {}. Mean {} over {} values, expected {}, accepted from {} to {} at {:g} % confidence; p = {}, {} "
      "tests "
      "made; {} % of the steps lie outside their pointwise bounds where {} % are expected.",
      what, to_string(v.verdict), number_text(v.mean, 5), v.count, number_text(v.expected, 5),
      number_text(v.bounds.lower, 5), number_text(v.bounds.upper, 5), 100.0 * v.confidence,
      number_text(v.p_value, 3), v.tests, number_text(100.0 * v.share_outside, 3),
      number_text(100.0 * v.expected_share_outside, 3));
}

void write_study_report(const std::filesystem::path& directory, const std::string& title,
                        std::span<const ReportedStudy> studies) {
  const std::vector<std::string> names = file_names(studies);
  const std::filesystem::path pdf_folder = directory / "figures";
  make_directories(pdf_folder);

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
  const std::vector<Drawing> drawings = draw_all(figures, pdf_folder);

  HtmlPage page(title, "Monte Carlo consistency of simulated filters, by Credence");
  page.section("Verdicts");
  page.table(verdict_table(analyses));
  for (std::size_t i = 0; i < studies.size(); ++i) {
    write_study_csv(directory / (names[i] + ".csv"), studies[i].analysis);
    write_trace_csv(directory / (names[i] + "-run.csv"), studies[i].trace);
    const std::size_t first = first_figure[i], count = first_figure[i + 1] - first;
    add_study(page, studies[i], names[i], std::span(figures).subspan(first, count),
              std::span(drawings).subspan(first, count), directory);
  }
  page.write(directory / "index.html");
}

}  // namespace credence
