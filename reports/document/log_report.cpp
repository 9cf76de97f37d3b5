#include "reports/document/log_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/document/study_report.h"
#include "reports/figures/draw_figures.h"
#include "reports/figures/study_figures.h"
#include "reports/render/atomic_file.h"
#include "reports/render/csv.h"
#include "reports/render/html_page.h"

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
  for (std::size_t k = 0; k < a.statistics.study.steps.size(); ++k) {
    std::vector<CsvField> row = {k + 1};
    for (const StepTest* test : {&a.nees.steps[k], &a.nis.steps[k]}) {
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
                             a.statistics.study.runs, 100.0 * a.confidence)};
  if (a.nees.count > 0) figure.panels.push_back(verdict_panel("ANEES", "mean NEES", a.nees, {}));
  if (a.nis.count > 0) figure.panels.push_back(verdict_panel("NIS", "mean NIS", a.nis, {}));
  figure.cols = static_cast<int>(figure.panels.size());
  return figure;
}

Panel whiteness_panel(const SensorAnalysis& s) {
  const WhitenessTest& w = s.whiteness;
  Panel panel{
      .title = s.name.empty() ? "Innovation" : s.name, .x_label = "lag (rows)", .y_label = "autocorrelation"};
  const FigureData lags = index_axis(std::ssize(w.autocorrelation));
  panel.x_range = AxisRange{0.0, static_cast<double>(lags.size()) + 1.0};  // no point on the frame
  FigureData lower;
  for (const double band : w.band) lower.push_back(-band);
  panel.series.push_back(band_series("white", ColourRole::bound, lags, lower, FigureData(w.band)));
  panel.series.push_back(point_series("measured", ColourRole::estimate, lags, FigureData(w.autocorrelation)));
  return panel;
}

/// NIS counts in bins that are equally likely: flat for a consistent filter.
Panel fit_panel(const LogStatistics& s) {
  constexpr std::size_t kBars = 32;
  const std::vector<std::int64_t>& counts = s.nis_fit.counts();
  const std::size_t group = counts.size() / kBars;
  const double total = static_cast<double>(s.nis_fit.count());
  Panel panel{
      .title = "NIS against its law", .x_label = "probability of a smaller NIS", .y_label = "density"};
  FigureData x, density;
  for (std::size_t i = 0; i < kBars; ++i) {
    double sum = 0.0;
    for (std::size_t j = i * group; j < (i + 1) * group; ++j) sum += static_cast<double>(counts[j]);
    x.push_back(static_cast<double>(i) / kBars);
    density.push_back(sum / total * kBars);
  }
  x.push_back(1.0);
  density.push_back(density.back());
  panel.series.push_back(step_series("measured", ColourRole::estimate, x, density));
  panel.series.push_back(level_series("consistent", ColourRole::neutral, 1.0));
  panel.y_range = AxisRange{0.0, std::max(2.0, 1.1 * *std::max_element(density.begin(), density.end()))};
  return panel;
}

std::vector<Figure> log_figures(const std::string& name, const LogAnalysis& a) {
  std::vector<Figure> figures;
  if (a.nees.count > 0 || a.nis.count > 0) figures.push_back(log_consistency_figure(name, a));
  Figure innovations{.name = name + "-innovations",
                     .caption =
                         "Innovations: NIS in equally likely classes, flat if consistent; autocorrelation "
                         "with the band of white ones."};
  if (a.fit.count > 0) innovations.panels.push_back(fit_panel(a.statistics));
  for (const SensorAnalysis& s : a.sensors) {
    if (s.whiteness.reason.empty() && innovations.panels.size() < 6)
      innovations.panels.push_back(whiteness_panel(s));
  }
  if (innovations.panels.empty()) return figures;
  innovations.cols = static_cast<int>(std::min<std::size_t>(3, innovations.panels.size()));
  innovations.rows = static_cast<int>((innovations.panels.size() + 2) / 3);
  figures.push_back(std::move(innovations));
  return figures;
}

std::string file_name(const std::string& name) {
  std::string result;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    result += plain ? c : '_';
  }
  return result.empty() ? "logs" : result;
}

void add_rejected(HtmlPage& page, const LogStatistics& s) {
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

void write_log_report(const std::filesystem::path& directory, const CheckedLogs& logs) {
  const LogAnalysis& a = logs.analysis;
  const std::string name = file_name(logs.name);
  const std::filesystem::path pdf_folder = directory / "figures";
  make_directories(pdf_folder);
  const std::vector<Figure> figures = log_figures(name, a);
  const std::vector<Drawing> drawings = draw_all(figures, pdf_folder);
  HtmlPage page(logs.name, "Consistency of a filter from its logs, by Credence");
  page.section("Verdicts");
  page.table(log_table(logs));
  if (a.statistics.has_truth) page.paragraph(verdict_sentence("NEES", a.nees));
  if (a.nis.count > 0) page.paragraph(verdict_sentence("NIS", a.nis));
  add_rejected(page, a.statistics);
  page.section("Figures");
  for (std::size_t i = 0; i < figures.size(); ++i) page.figure(figures[i], drawings[i], directory);
  write_steps(directory / (name + ".csv"), a);
  page.link("every step as CSV", name + ".csv");
  page.write(directory / "index.html");
}

}  // namespace credence
