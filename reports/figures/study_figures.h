#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "montecarlo/engine/experiment.h"
#include "reports/figures/figure.h"

/// @file
/// The figures of one study. `name` begins the file name of each.

namespace credence::internal {

/// The paper's four columns for one run of a monobot: positions with 2σ and measurements, of the vehicle and
/// of the landmarks; Kalman gains; vehicle error with 2σ; landmark errors with 2σ.
Figure monobot_run_figure(const std::string& name, const RunTrace& trace);

/// One run in the plane: true and estimated path, landmarks, and their 2σ ellipses; pose errors with 2σ.
/// times: of the steps; null where not known.
Figure planar_run_figure(const std::string& name, const RunTrace& trace, const StepTimes* times);

/// Panels of states or blocks that a figure has at most.
inline constexpr std::size_t kStatePanels = 15, kBlockPanels = 6;

/// One run of a world without a picture of its own: the error of every state with 2σ; of more than
/// kStatePanels first those of the inconsistent ones among `blocks`, the worst first, then as they stand.
Figure states_run_figure(const std::string& name, const RunTrace& trace,
                         std::span<const BlockVerdict> blocks = {}, const StepTimes* times = nullptr);

/// Mean NEES and NIS over the steps, of several sensors each its own, with pointwise and simultaneous bounds
/// and, for linear models, the exact curves; and the traces of P.
Figure consistency_figure(const std::string& name, const StudyAnalysis& analysis);

/// "means over 200 runs", "of one run": what a curve over steps shows.
std::string over_runs_text(std::int64_t runs);

/// The label of an axis of errors, and what turns them into its unit.
struct ErrorUnit {
  std::string label = "error";
  double scale = 1.0;
};

/// Of a unit of the layout: "error (m/s)", of radians in degrees; "error" where it is empty, not known.
ErrorUnit error_unit(std::string_view unit);

/// The means of every step with pointwise and simultaneous bounds; `exact` may be empty. Where fewer than
/// half of the steps have data they alone are shown; where the dof falls often all is shown over it,
/// without `exact`.
Panel verdict_panel(const std::string& title, const char* y_label, const ConsistencyVerdict& verdict,
                    const FigureData& exact);

/// Adds to the caption where panels of verdicts have logarithmic axes that do not reach down to all means.
void tell_cut_means(Figure& figure);

/// A verdict that lives elsewhere, with the title of its panel.
struct TitledVerdict {
  std::string title;
  const ConsistencyVerdict* verdict = nullptr;
};

/// A panel for each verdict with data; of more than kBlockPanels those that fit least, which is added to the
/// caption, where they are called `what`.
std::vector<Panel> verdict_panels(std::vector<TitledVerdict> verdicts, const char* y_label, const char* what,
                                  std::string& caption);

/// The mean NIS; of several sensors, whose steps and dof may differ, a panel for each with data, of more than
/// kBlockPanels those that fit least, which is added to the caption.
std::vector<Panel> nis_panels(const Judgement& judgement, std::string& caption);

/// The figures of a study but that of its tests (evidence_figure), with one of its runs; one without panels
/// is of what there is no data for.
std::vector<Figure> study_figures(const std::string& name, const StudyAnalysis& analysis,
                                  const std::optional<RunTrace>& trace);

}  // namespace credence::internal
