#include "reports/document/sweep_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "montecarlo/scenario/scenario_text.h"
#include "reports/document/rank_map_report.h"
#include "reports/document/study_json.h"
#include "reports/document/study_table.h"
#include "reports/document/swept_values.h"
#include "reports/figures/draw_figures.h"
#include "reports/render/atomic_file.h"
#include "reports/render/csv.h"
#include "reports/render/html_page.h"
#include "reports/render/json_numbers.h"

namespace credence {
namespace {

/// The number of a swept value, NaN for a word.
double number_of(const ScalarValue& value) {
  if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
  if (const auto* d = std::get_if<double>(&value)) return *d;
  return std::nan("");
}

/// The level of the tests of all configurations together.
double confidence_of(const SweepAnalysis& sweep) { return sweep.studies.front().scenario.study.confidence; }

/// Whether values spread like powers: all positive, and the middle one nearer to the geometric than to the
/// arithmetic mean of the ends.
bool is_geometric(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  if (values.size() < 3 || values.front() <= 0.0) return false;
  const double middle = values[values.size() / 2];
  return std::abs(middle - std::sqrt(values.front() * values.back())) <
         std::abs(middle - 0.5 * (values.front() + values.back()));
}

/// The curve of one setting of the other axes: mean over expected, and the factors on the claimed covariance
/// that a test at the verdict's confidence would not reject. They include 1 where the verdict is consistent.
struct RatioCurve {
  FigureData x, ratio, lower, upper;

  void add(double at, const ConsistencyVerdict& v) {
    x.push_back(at);
    ratio.push_back(v.mean / v.expected);
    lower.push_back(v.mean / v.bounds.upper);
    upper.push_back(v.mean / v.bounds.lower);
  }
};

Panel ratio_panel(const char* what, const SweepAxis& axis, const std::map<std::string, RatioCurve>& curves) {
  Panel panel{
      .title = what, .x_label = axis.path, .y_label = fmt::format("mean {} / expected", what), .log_y = true};
  panel.series.push_back(level_series("expected", ColourRole::neutral, 1.0));
  Index i = 0;
  for (const auto& [label, c] : curves) {
    const ColourRole role = numbered_role(i++);
    panel.log_x = is_geometric(c.x);
    panel.series.push_back(line_series("", role, c.x, c.ratio));
    panel.series.push_back(
        error_bar_series(label.empty() ? "measured" : label, role, c.x, c.ratio, c.lower, c.upper));
  }
  return panel;
}

/// Mean NEES over expected along the numeric axis with most values, one curve for each setting of the others.
std::vector<Figure> sweep_figures(const SweepAnalysis& sweep) {
  const SweepPlan& plan = sweep.plan;
  std::size_t axis = plan.axes.size(), longest = 1;
  for (std::size_t a = 0; a < plan.axes.size(); ++a) {
    const std::size_t size = plan.axes[a].values.size();
    if (size > longest && !std::isnan(number_of(plan.axes[a].values.front()))) {
      axis = a;
      longest = size;
    }
  }
  if (axis == plan.axes.size()) return {};

  std::map<std::string, RatioCurve> nees, nis;
  for (std::size_t n = 0; n < sweep.studies.size(); ++n) {
    const StudyAnalysis& a = sweep.studies[n];
    const SweepPoint& point = sweep.point(n);
    std::string label;
    for (std::size_t i = 0; i < plan.axes.size(); ++i) {
      if (i != axis) label += (label.empty() ? "" : ", ") + swept_text(point.values[i]);
    }
    nees[label].add(number_of(point.values[axis]), a.nees);
    nis[label].add(number_of(point.values[axis]), a.nis);
  }
  constexpr std::size_t kMostCurves = 6;
  if (nees.size() > kMostCurves) return {};
  return {{.name = "sweep",
           .caption = fmt::format(
               "Mean NEES and NIS over their expected values, logarithmic: 1 is consistent, above "
               "is optimistic, below pessimistic. Bars: factors on the claimed covariance that "
               "agree with what was measured, each at {:g} %; a bar without 1 is a verdict.",
               100.0 * confidence_of(sweep)),
           .rows = 1,
           .cols = 2,
           .panels = {ratio_panel("NEES", plan.axes[axis], nees), ratio_panel("NIS", plan.axes[axis], nis)}}};
}

void write_sweep_csv(const std::filesystem::path& target, const SweepAnalysis& sweep) {
  std::vector<std::string> columns = {"configuration"};
  for (const SweepAxis& axis : sweep.plan.axes) columns.push_back(axis.path);
  for (const char* name : {"runs", "failed", "nees_mean", "nees_expected", "nees_lower", "nees_upper",
                           "nees_p_value", "nees_verdict", "nis_mean", "nis_expected", "nis_lower",
                           "nis_upper", "nis_p_value", "nis_verdict", "trace_last"}) {
    columns.emplace_back(name);
  }
  if (!sweep.rank_map.empty()) {
    for (const char* name : {"rank_inflation", "rank_observability", "measured_bounded", "growth_exponent",
                             "growth_per_step", "predicted_bounded", "paper_condition_holds"}) {
      columns.emplace_back(name);
    }
  }
  CsvWriter csv(target, columns);
  const auto number = [](double v) { return std::isfinite(v) ? CsvField(v) : CsvField(""); };
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    const StudyAnalysis& a = sweep.studies[i];
    const SweepPoint& point = sweep.point(i);
    std::vector<CsvField> row = {point.id};
    for (const ScalarValue& value : point.values) row.emplace_back(swept_text(value));
    row.emplace_back(a.statistics.runs);
    row.emplace_back(a.statistics.failures.size());
    for (const ConsistencyVerdict* v : {&a.nees, &a.nis}) {
      for (const double x : {v->mean, v->expected, v->bounds.lower, v->bounds.upper, v->p_value}) {
        row.push_back(number(x));
      }
      row.emplace_back(std::string(to_string(v->verdict)));
    }
    row.push_back(a.covariance.trace.empty() ? CsvField("") : number(a.covariance.trace.back()));
    if (!sweep.rank_map.empty()) {
      const RankMapCell& c = sweep.rank_map[i];
      row.insert(row.end(), {c.inflation_rank, c.observability_rank, c.bounded ? 1 : 0, c.growth_exponent,
                             c.growth_per_step, c.predicted ? 1 : 0, c.paper ? 1 : 0});
    }
    csv.add(row);
  }
  csv.commit();
}

bool stands(const StudyAnalysis& analysis, double sweep_p_value) {
  return is_inconsistent(overall_verdict(analysis)) &&
         sweep_p_value <= 1.0 - analysis.scenario.study.confidence;
}

std::string family_note(const SweepAnalysis& sweep) {
  std::size_t alone = 0, together = 0;
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    alone += is_inconsistent(overall_verdict(sweep.studies[i])) ? 1 : 0;
    together += stands(sweep.studies[i], sweep.p_values[i]) ? 1 : 0;
  }
  const double percent = 100.0 * (1.0 - confidence_of(sweep));
  return fmt::format(
      "{} of {} configurations are inconsistent when each is judged alone, {} when all are judged together: "
      "of "
      "these at most {:g} % are expected to be false (Benjamini-Yekutieli).",
      alone, sweep.studies.size(), together, percent);
}

ReportTable configuration_table(const SweepAnalysis& sweep) {
  using enum ColumnAlign;
  const SweepPlan& plan = sweep.plan;
  ReportTable table{.title = fmt::format("{}: {} configurations", plan.name, plan.points.size()),
                    .columns = {},
                    .rows = {},
                    .notes = {}};
  for (const SweepAxis& axis : plan.axes) {
    table.columns.push_back({axis.path, std::isnan(number_of(axis.values.front())) ? words : numbers});
  }
  for (const char* title : {"runs", "mean NEES", "expected"}) table.columns.push_back({title});
  table.columns.push_back({"NEES says", words});
  for (const char* title : {"mean NIS", "expected"}) table.columns.push_back({title});
  table.columns.push_back({"NIS says", words});
  table.columns.push_back({"together", words});
  table.columns.push_back({"last tr P"});
  table.columns.push_back({"failed runs"});
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    const StudyAnalysis& a = sweep.studies[i];
    std::vector<TableCell> row;
    for (const ScalarValue& value : sweep.point(i).values) row.emplace_back(swept_text(value));
    row.insert(row.end(),
               {a.statistics.runs, a.nees.mean, a.nees.expected, verdict_cell(a.nees.verdict), a.nis.mean,
                a.nis.expected, verdict_cell(a.nis.verdict),
                stands(a, sweep.p_values[i]) ? TableCell("inconsistent", CellTone::alarm) : TableCell(""),
                a.covariance.trace.empty() ? std::nan("") : a.covariance.trace.back(),
                a.statistics.failures.size()});
    table.add(std::move(row));
  }
  if (!sweep.studies.empty()) table.notes.push_back(family_note(sweep));
  if (sweep.studies.size() < plan.points.size()) {
    table.notes.push_back(
        fmt::format("{} of {} configurations have results", sweep.studies.size(), plan.points.size()));
  }
  if (plan.skipped > 0)
    table.notes.push_back(fmt::format("{} impossible configurations left out", plan.skipped));
  return table;
}

}  // namespace

std::vector<ReportTable> sweep_tables(const SweepAnalysis& sweep) {
  if (sweep.rank_map.empty()) return {configuration_table(sweep)};
  return {rank_map_table(sweep.rank_map, confidence_of(sweep)), rank_map_disagreements(sweep.rank_map)};
}

std::string sweep_json(const SweepAnalysis& sweep) {
  const SweepPlan& plan = sweep.plan;
  Json document;
  document["schema"] = kSchema;
  document["name"] = plan.name;
  document["points"] = plan.points.size();
  document["skipped_impossible"] = plan.skipped;
  if (!sweep.rank_map.empty()) {
    document["rank_map"] = rank_map_json(sweep.rank_map, confidence_of(sweep));
    return document.dump(1);
  }
  Json configurations = Json::array();
  for (std::size_t n = 0; n < sweep.studies.size(); ++n) {
    Json j = Json::parse(study_json(sweep.studies[n]));
    j["swept"] = swept_json(plan, sweep.point(n));
    j["sweep_p_value"] = json_number(sweep.p_values[n]);
    configurations.push_back(std::move(j));
  }
  document["configurations"] = std::move(configurations);
  return document.dump(1);
}

void write_sweep_report(const std::filesystem::path& directory, const SweepAnalysis& sweep,
                        const Provenance& provenance) {
  const std::filesystem::path pdf_folder = directory / "figures";
  make_directories(pdf_folder);
  const bool map = !sweep.rank_map.empty();
  const std::vector<Figure> figures =
      map ? std::vector<Figure>{rank_map_figure(sweep.rank_map)} : sweep_figures(sweep);
  const std::vector<Drawing> drawings = draw_all(figures, pdf_folder);
  write_sweep_csv(directory / "sweep.csv", sweep);

  HtmlPage page(sweep.plan.name, "A sweep of configurations, by Credence");
  page.section(map ? "The map of ranks" : "Verdicts");
  for (const ReportTable& table : sweep_tables(sweep)) page.table(table);
  page.link("every configuration as CSV", "sweep.csv");
  for (std::size_t i = 0; i < figures.size(); ++i) page.figure(figures[i], drawings[i], directory);
  page.section("Settings");
  page.verbatim(canonical_toml(sweep.plan));
  page.provenance(provenance);
  page.write(directory / "index.html");
}

}  // namespace credence
