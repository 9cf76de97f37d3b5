#include "reports/document/comparison_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "reports/figures/draw_figures.h"
#include "reports/figures/figure.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"
#include "reports/render/number_text.h"

namespace credence {
namespace {

bool is_untrusted(const ComparedStudy& study) {
  return study.verdict == to_string(Verdict::optimistic) || study.verdict == to_string(Verdict::mixed);
}

Panel over_steps(std::span<const ComparedStudy> studies, FigureText title,
                 std::vector<double> ComparedStudy::*ratios) {
  Panel panel{.title = std::move(title), .x_label = "step", .y_label = "mean over dof"};
  panel.series.push_back(level_series("consistent", ColourRole::neutral, 1.0));
  for (std::size_t i = 0; i < studies.size(); ++i) {
    const std::vector<double>& values = studies[i].*ratios;
    if (values.empty()) continue;
    panel.series.push_back(line_series(studies[i].name, numbered_role(static_cast<Index>(i)),
                                       index_axis(std::ssize(values)), values));
  }
  return panel;
}

/// NEES over dof of each study less that of the first, run by run.
Panel differences(std::span<const ComparedStudy> studies, double confidence) {
  Panel panel{.title = "Against the first, run by run",
              .x_label = "study, as in the table",
              .y_label = "difference of NEES over dof",
              .x_range = AxisRange{0.5, static_cast<double>(studies.size()) + 0.5}};
  for (std::size_t i = 1; i <= studies.size(); ++i) panel.x_names.push_back(fmt::to_string(i));
  panel.series.push_back(level_series("no difference", ColourRole::neutral, 0.0));
  for (std::size_t i = 1; i < studies.size(); ++i) {
    const std::optional<MeanInterval> d = paired_difference(studies[i], studies.front(), confidence);
    if (!d) continue;
    panel.series.push_back(error_bar_series(studies[i].name, numbered_role(static_cast<Index>(i)),
                                            {static_cast<double>(i) + 1.0}, {d->mean}, {d->lower},
                                            {d->upper}));
  }
  return panel;
}

Figure comparison_figure(std::span<const ComparedStudy> studies, double confidence) {
  Figure figure{
      .name = "comparison",
      .caption =
          "Mean over the runs at every step, over its expected value: above 1 the errors are larger "
          "than the covariance says.",
      .rows = 1,
      .cols = 0};
  for (Panel& panel : std::vector{over_steps(studies, "NEES", &ComparedStudy::nees_of_steps),
                                  over_steps(studies, "NIS", &ComparedStudy::nis_of_steps),
                                  differences(studies, confidence)}) {
    if (panel.series.size() > 1) figure.panels.push_back(std::move(panel));
  }
  figure.cols = static_cast<int>(figure.panels.size());
  return figure;
}

}  // namespace

ReportAnswer comparison_answer(std::span<const ComparedStudy> studies) {
  std::vector<std::string> untrusted;
  const ComparedStudy* nearest = nullptr;
  const auto distance = [](const ComparedStudy& s) { return std::abs(std::log(s.factor.mean)); };
  for (const ComparedStudy& study : studies) {
    if (is_untrusted(study)) untrusted.push_back(study.name);
    if (!std::isfinite(distance(study))) continue;
    if (nearest == nullptr || distance(study) < distance(*nearest)) nearest = &study;
  }
  ReportAnswer answer{.tone = untrusted.empty() ? CellTone::good : CellTone::alarm, .text = {}};
  answer.text = untrusted.empty() ? fmt::format("Of {} results none is called optimistic", studies.size())
                                  : fmt::format("{} of {} cannot be trusted: {}", untrusted.size(),
                                                studies.size(), fmt::join(untrusted, ", "));
  if (nearest != nullptr) {
    answer.text += fmt::format("; nearest to right: {}, factor on P {}", nearest->name,
                               number_text(nearest->factor.mean, 3));
  }
  return answer;
}

void write_comparison_report(const ReportFolder& directory, std::span<const ComparedStudy> studies,
                             double confidence, const Provenance& provenance) {
  make_directories(directory);
  HtmlPage page("Results side by side", fmt::format("{} results, compared by Credence", studies.size()));
  const ReportAnswer answer = comparison_answer(studies);
  page.answer(answer.tone, answer.text + ".");
  page.section("Side by side");
  ReportTable table = comparison_table(studies, confidence);
  table.title = "Each result, and what it differs by from the first";
  page.table(table);
  if (const Figure figure = comparison_figure(studies, confidence); !figure.panels.empty()) {
    page.figure(figure, draw_all(std::vector{figure}, directory).front(), directory);
  }
  page.provenance(provenance);
  page.write(directory / "index.html");
}

}  // namespace credence
