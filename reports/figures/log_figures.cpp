#include "reports/figures/log_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "reports/document/logs/log_table.h"
#include "reports/document/study/calibration_report.h"
#include "reports/figures/figure_axis.h"
#include "reports/figures/step_axis.h"
#include "reports/figures/study_figures.h"

namespace credence::internal {
namespace {

Figure log_consistency_figure(const std::string& name, const LogAnalysis& a) {
  const bool has_nees = a.judgement.nees.count > 0, has_nis = a.judgement.nis.count > 0;
  Figure figure{
      .name = name + "-consistency",
      .caption = fmt::format("{}, {}. A consistent filter stays within the "
                             "band at {:g} % of single steps, and between the outer lines at all steps.",
                             !has_nis    ? "NEES"
                             : !has_nees ? "NIS"
                                         : "NEES and NIS",
                             over_runs_text(a.evidence.study.runs), 100.0 * a.judgement.confidence)};
  if (has_nees) figure.panels.push_back(verdict_panel("NEES", "mean NEES", a.judgement.nees, {}));
  if (has_nis) std::ranges::move(nis_panels(a.judgement, figure.caption), std::back_inserter(figure.panels));
  leave_out_start(figure, true);
  tell_cut_means(figure);
  arrange(figure);
  return figure;
}

/// Errors of the first run, state by state: of all states of an inertial filter, of a map the first ones.
Figure errors_figure(const std::string& name, const RunErrors& run, const LogAnalysis& a) {
  const std::size_t states = a.evidence.layout.states.size();
  const StepTimes* const times = a.judgement.nees.times.get();
  // A component that the filter does not estimate has no error in any row.
  std::vector<const RunErrors::State*> estimated;
  for (const RunErrors::State& state : run.states) {
    if (!std::ranges::all_of(state.error, [](double e) { return std::isnan(e); }))
      estimated.push_back(&state);
  }
  Figure figure{
      .name = name + "-errors",
      .caption = fmt::format("The first run: errors{} with the ±2σ that the filter claims, between which "
                             "at each step 95 of 100 runs of a consistent filter lie.",
                             states > run.states.size()
                                 ? fmt::format(" of the first {} of {} states", run.states.size(), states)
                                 : "")};
  const FigureData x =
      figure_data(run.step, [&](double step) { return step_place(times, static_cast<std::int64_t>(step)); });
  for (const RunErrors::State* state : estimated) {
    const ErrorUnit unit = error_unit(state->unit);
    const auto scaled = [](double factor) { return [factor](double value) { return factor * value; }; };
    Panel panel{.title = state->name, .x_label = step_label(times), .y_label = unit.label};
    panel.series =
        error_series("error", ColourRole::estimate, x, figure_data(state->error, scaled(unit.scale)),
                     figure_data(state->sigma, scaled(2.0 * unit.scale)));
    figure.panels.push_back(std::move(panel));
  }
  leave_out_start(figure, false);
  arrange(figure);
  return figure;
}

/// NEES of the blocks over the steps, the pose first; of many those that fit least first.
Figure blocks_figure(const std::string& name, const LogAnalysis& a) {
  Figure figure{.name = name + "-blocks",
                .caption = "NEES of the blocks of states: which part of the state, and since when."};
  std::vector<TitledVerdict> verdicts;
  for (const BlockVerdict* block : blocks_in_order(a)) verdicts.push_back({block->name, &block->verdict});
  figure.panels = verdict_panels(std::move(verdicts), "mean NEES", "blocks", figure.caption);
  leave_out_start(figure, true);
  tell_cut_means(figure);
  arrange(figure);
  return figure;
}

}  // namespace

std::vector<Figure> log_figures(const std::string& name, const CheckedLogs& logs) {
  return {log_consistency_figure(name, logs.analysis),
          errors_figure(name, logs.first_run, logs.analysis),
          sigma_figure(name, logs.calibration, logs.analysis.evidence.layout),
          distance_figure(name, logs.calibration),
          stanford_figure(name, logs.calibration),
          blocks_figure(name, logs.analysis)};
}

}  // namespace credence::internal
