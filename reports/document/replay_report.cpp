#include "reports/document/replay_report.h"

#include <fmt/format.h>

#include <cmath>

#include "core/nan.h"
#include "reports/document/replay_tables.h"
#include "reports/figures/draw_figures.h"
#include "reports/figures/replay_figures.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"

namespace credence {
namespace {

/// NEES of every run over time, and their average with the bounds of its verdict.
Figure nees_figure(std::span<const ReportedReplay> replays, const RecordedNeesVerdict& nees) {
  Panel panel{.title = "NEES over time", .x_label = "time (s)", .y_label = "NEES", .log_y = true};
  for (std::size_t i = 0; i < replays.size(); ++i) {
    FigureData t, value;
    for (const ReplayReference& reference : replays[i].result.references) {
      t.push_back(reference.time_s);
      value.push_back(reference.nees > 0.0 ? reference.nees : kNaN);
    }
    panel.series.push_back(
        line_series(replay_name(replays[i].result), numbered_role(static_cast<Index>(i)), t, value));
  }
  FigureData t, upper;
  for (std::size_t k = 0; k < nees.time_s.size(); ++k) {
    const StepTest& step = nees.verdict.steps[k];
    t.push_back(nees.time_s[k]);
    upper.push_back(step.count > 0 ? step.simultaneous_upper : kNaN);
  }
  panel.series.push_back(
      line_series("a consistent filter's average stays below", ColourRole::bound, t, upper));
  panel.series.push_back(level_series("expected", ColourRole::truth, nees.verdict.expected));
  panel.series.back().stroke = StrokeStyle::dotted;
  return {.name = "nees",
          .caption =
              "NEES of each run against its reference; the bound holds for the average of the runs at "
              "all seconds together.",
          .panels = {panel},
          .row_height = 18.0};
}

std::string file_name(const ReplayResult& result) {
  std::string name = result.dataset;
  for (const char c : result.run) name += (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ? c : '-';
  return name;
}

}  // namespace

void write_replay_report(const ReportFolder& directory, std::span<const ReportedReplay> replays,
                         const ReplayJudgement& judgement, const Provenance& provenance) {
  std::vector<Figure> figures{nees_figure(replays, judgement.nees)};
  for (std::size_t i = 0; i < replays.size(); ++i) {
    const std::string number = replays.size() > 1 ? fmt::format("{}-", i + 1) : "";
    for (Figure& figure : replay_figures(number + file_name(replays[i].result), replays[i].result))
      figures.push_back(std::move(figure));
  }
  const std::vector<Drawing> drawings = draw_all(figures, directory);

  HtmlPage page(fmt::format("EKF-SLAM on {}", replays.size() == 1 ? replay_name(replays.front().result)
                                                                  : replays.front().result.dataset),
                "Real data replayed");
  const ReportAnswer answer = replay_answer(replays, judgement);
  page.answer(answer.tone, answer.text + ".");
  page.section("What can be said");
  page.table(judgement_table(replays, judgement));
  page.figure(figures.front(), drawings.front(), directory);
  if (replays.size() > 1) page.table(replays_table(replays));
  std::size_t next = 1;
  for (const ReportedReplay& replay : replays) {
    page.section(replay_name(replay.result));
    page.table(replay_table(replay));
    for (int i = 0; i < 2; ++i, ++next) page.figure(figures[next], drawings[next], directory);
    std::vector<std::pair<std::string, std::string>> facts;
    for (const ReplaySettingText& s : replay_settings_text(replay.result.settings))
      facts.emplace_back(s.key, s.value);
    page.folded("Settings", [&] { page.facts(facts); });
  }
  page.provenance(provenance);
  page.write(directory / "index.html");
}

}  // namespace credence
