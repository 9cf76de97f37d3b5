#include "reports/document/log_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/manifold/angle.h"
#include "reports/document/calibration_report.h"
#include "reports/document/judgement_report.h"
#include "reports/document/log_gate.h"
#include "reports/document/study_report.h"
#include "reports/document/study_table.h"
#include "reports/figures/draw_figures.h"
#include "reports/figures/study_figures.h"
#include "reports/render/atomic_file.h"
#include "reports/render/csv.h"
#include "reports/render/html_page.h"
#include "reports/render/number_text.h"

namespace credence {
namespace {

CsvField number_field(double value) { return std::isfinite(value) ? CsvField(value) : CsvField(""); }

void write_steps(const std::filesystem::path& target, const LogAnalysis& a) {
  std::vector<std::string> columns = {"step"};
  for (const char* name : {"nees", "nis"}) {
    for (const char* what : {"mean", "expected", "lower", "upper", "p_value", "runs"}) {
      columns.push_back(fmt::format("{}_{}", name, what));
    }
  }
  CsvWriter csv(target, columns);
  for (std::size_t k = 0; k < a.evidence.study.steps.size(); ++k) {
    std::vector<CsvField> row = {1 + static_cast<std::int64_t>(k) * a.evidence.step_stride};
    for (const StepTest* test : {&a.judgement.nees.steps[k], &a.judgement.nis.steps[k]}) {
      for (const double value : {test->mean, test->expected, test->lower, test->upper, test->p_value}) {
        row.push_back(number_field(value));
      }
      row.emplace_back(test->count);
    }
    csv.add(row);
  }
  csv.commit();
}

Figure log_consistency_figure(const std::string& name, const LogAnalysis& a) {
  Figure figure{
      .name = name + "-consistency",
      .caption = fmt::format("NEES and NIS, means over {} runs. A consistent filter stays within the "
                             "band at {:g} % of single steps, and between the outer lines at all steps.",
                             a.evidence.study.runs, 100.0 * a.judgement.confidence)};
  if (a.judgement.nees.count > 0)
    figure.panels.push_back(verdict_panel("ANEES", "mean NEES", a.judgement.nees, {}));
  if (a.judgement.nis.count > 0)
    figure.panels.push_back(verdict_panel("NIS", "mean NIS", a.judgement.nis, {}));
  figure.cols = static_cast<int>(figure.panels.size());
  return figure;
}

/// Errors of the first run, state by state.
Figure errors_figure(const std::string& name, const RunErrors& run) {
  constexpr std::size_t kPanels = 6;
  // A component that the filter does not estimate has no error in any row.
  std::vector<const RunErrors::State*> estimated;
  for (const RunErrors::State& state : run.states) {
    if (!std::ranges::all_of(state.error, [](double e) { return std::isnan(e); }))
      estimated.push_back(&state);
  }
  const std::size_t shown = std::min(kPanels, estimated.size());
  Figure figure{
      .name = name + "-errors",
      .caption = fmt::format("The first run: errors{} with the ±2σ that the filter claims; a consistent "
                             "filter stays between them at 95 % of the steps.",
                             estimated.size() > shown ? fmt::format(" of the first {} states", shown) : ""),
      .rows = static_cast<int>(std::max<std::size_t>(1, (shown + 2) / 3)),
      .cols = static_cast<int>(std::clamp<std::size_t>(shown, 1, 3))};
  for (std::size_t i = 0; i < shown; ++i) {
    const RunErrors::State& state = *estimated[i];
    const double scale = state.angle ? 1.0 / kRadiansPerDegree : 1.0;
    FigureData error, lower, upper;
    for (std::size_t k = 0; k < run.step.size(); ++k) {
      error.push_back(scale * state.error[k]);
      upper.push_back(2.0 * scale * state.sigma[k]);
      lower.push_back(-upper.back());
    }
    Panel panel{.title = state.name, .x_label = "step", .y_label = state.angle ? "error (°)" : "error"};
    panel.series = {line_series("±2σ", ColourRole::bound, FigureData(run.step), std::move(lower)),
                    line_series("", ColourRole::bound, FigureData(run.step), std::move(upper)),
                    line_series("error", ColourRole::estimate, FigureData(run.step), std::move(error))};
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

/// NEES of the blocks over the steps, the pose first.
Figure blocks_figure(const std::string& name, const LogAnalysis& a) {
  constexpr std::size_t kPanels = 6;
  Figure figure{
      .name = name + "-blocks",
      .caption = "NEES of the blocks of states, the pose first: which part of the state, and since when."};
  for (const BlockVerdict* block : blocks_in_order(a)) {
    if (block->verdict.count == 0 || figure.panels.size() == kPanels) continue;
    figure.panels.push_back(verdict_panel(block->name, "mean NEES", block->verdict, {}));
  }
  figure.cols = static_cast<int>(std::clamp<std::size_t>(figure.panels.size(), 1, 3));
  figure.rows = static_cast<int>(std::max<std::size_t>(1, (figure.panels.size() + 2) / 3));
  return figure;
}

std::vector<Figure> log_figures(const std::string& name, const CheckedLogs& logs) {
  const LogAnalysis& a = logs.analysis;
  std::vector<Figure> figures;
  if (a.judgement.nees.count > 0 || a.judgement.nis.count > 0)
    figures.push_back(log_consistency_figure(name, a));
  if (!logs.first_run.step.empty() && !logs.first_run.states.empty()) {
    if (Figure errors = errors_figure(name, logs.first_run); !errors.panels.empty())
      figures.push_back(std::move(errors));
  }
  if (Figure sigma = sigma_figure(name, logs.calibration, a.evidence.layout.states); !sigma.panels.empty())
    figures.push_back(std::move(sigma));
  for (Figure& figure :
       std::array{distance_figure(name, logs.calibration), stanford_figure(name, logs.calibration)}) {
    if (!figure.panels.empty()) figures.push_back(std::move(figure));
  }
  if (Figure blocks = blocks_figure(name, a); !blocks.panels.empty()) figures.push_back(std::move(blocks));
  Figure evidence = evidence_figure(name, a.judgement);
  if (!evidence.panels.empty()) figures.push_back(std::move(evidence));
  return figures;
}

/// The mean NEES of the first log in every chart.
ReportTable charts_table(const LogPoses& log) {
  ReportTable table{
      .title =
          fmt::format("Mean NEES of the pose in every chart, 6 expected; judged is {}", log.charts.declared),
      .columns = {{"chart", ColumnAlign::words},
                  {"if it were written so"},
                  {"p", ColumnAlign::words},
                  {"carried over"}},
      .rows = {},
      .notes = {
          fmt::format(
              "Of {}, {} rows. If it were written so: the numbers of the file, read as of this chart, and "
              "whether they would fit. Carried over: the covariance of the chart that is judged, taken "
              "into this one by the Jacobian at the error.",
              log.file.filename().string(), log.charts.rows),
          "The chart is a matter of the program that wrote the log (--chart), and to be chosen before one "
          "looks "
          "at these numbers."}};
  for (const ChartNees& nees : log.charts.charts) {
    const bool judged = nees.chart == log.charts.declared;
    table.add({judged ? nees.chart + " (judged)" : nees.chart, nees.as_written,
               std::isnan(nees.p_value) ? "–" : p_value_text(nees.p_value), nees.carried});
  }
  return table;
}

std::string file_name(const std::string& name) {
  std::string result;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    result += plain ? c : '_';
  }
  return result.empty() ? "logs" : result;
}

void add_rejected(HtmlPage& page, const Evidence& s) {
  if (s.rejected.empty()) return;
  page.callout(
      CellTone::alarm,
      fmt::format("{} of {} rows were rejected: counted, never repaired. Neither their NEES nor their NIS "
                  "is in the numbers above.",
                  s.rejected_rows(), s.rows));
  std::vector<std::string> items;
  for (const auto& [reason, rows] : s.rejected) {
    items.push_back(fmt::format("{} rows: {}; the first is {}", rows.count, reason, rows.first));
  }
  page.bullets(items);
}

}  // namespace

void write_log_report(const ReportFolder& directory, const CheckedLogs& logs, const Provenance& provenance) {
  const LogAnalysis& a = logs.analysis;
  const std::string name = file_name(logs.name);
  const std::vector<Figure> figures = log_figures(name, logs);
  const std::vector<Drawing> drawings = draw_all(figures, directory);
  HtmlPage page(logs.name, "Consistency of a filter from its logs");
  page.answer(verdict_cell(a.judgement.word.verdict).tone, log_answer(logs) + ".");
  if (logs.gate)
    page.callout(logs.gate->worse.empty() ? CellTone::good : CellTone::alarm, gate_sentence(*logs.gate));
  page.section("Verdicts");
  ReportTable verdicts = log_verdicts(logs, a.judgement.blocks.size());
  verdicts.title = "One row for the whole state, the innovations, and each block of states";
  page.table(verdicts);
  add_rejected(page, a.evidence);
  if (const std::vector<std::string> advice = advice_sentences(a.judgement); !advice.empty()) {
    page.section("What to do");
    page.bullets(advice);
  }
  if (const std::vector<std::string> mends = calibration_sentences(logs.calibration); !mends.empty()) {
    page.section(is_inconsistent(a.judgement.word.verdict) ? "What would mend it" : "Factors on P");
    page.bullets(mends);
  }
  const auto with_charts =
      std::ranges::find_if(logs.poses, [](const LogPoses& log) { return !log.charts.charts.empty(); });
  if (with_charts != logs.poses.end()) {
    page.section("Charts");
    page.table(charts_table(*with_charts));
  }
  page.section("Figures");
  const auto add_figures = [&](bool evidence) {
    for (std::size_t i = 0; i < figures.size(); ++i) {
      if (figures[i].name.ends_with(kEvidenceSuffix) == evidence)
        page.figure(figures[i], drawings[i], directory);
    }
  };
  add_figures(false);
  if (!logs.calibration.bins.empty()) {
    page.section("Where P lies");
    page.folded("Errors by claimed σ",
                [&] { page.table(sigma_table(logs.calibration, a.evidence.layout.states)); });
  }
  page.section("Tests");
  page.folded("All tests and statistics", [&] {
    std::vector<std::string> sentences;
    if (a.evidence.has_truth) sentences.push_back(verdict_sentence("NEES", a.judgement.nees));
    if (a.judgement.nis.count > 0) sentences.push_back(verdict_sentence("NIS", a.judgement.nis));
    for (std::string& sentence : log_statistics(logs)) sentences.push_back(std::move(sentence));
    if (!sentences.empty()) page.bullets(sentences);
    page.table(tests_table(a.judgement));
    if (!a.judgement.accuracy.empty()) {
      page.table(accuracy_table(a.judgement, a.bound ? &*a.bound : nullptr));
    }
    add_figures(true);
  });
  write_steps(directory / (name + ".csv"), a);
  page.link("every step as CSV", name + ".csv");
  page.provenance(provenance);
  page.write(directory / "index.html");
}

}  // namespace credence
