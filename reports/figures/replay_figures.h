#pragma once

#include <string>
#include <vector>

#include "datasets/replay/replay_result.h"
#include "reports/figures/figure.h"

/// @file
/// Figures of a replay like the paper's 5 to 8. `name` begins the file name of each.

namespace credence::internal {

/// The paper's Figures 5 to 7 for one replay: vehicle error against the reference with 2σ, landmark errors
/// with the band of their 2σ, gains, traces of the covariance; and the NIS of single observations.
Figure replay_run_figure(const std::string& name, const std::string& caption, const ReplayResult& result);

/// A panel of the paper's Figure 8: path and map over the reference and the survey, with 2σ ellipses.
Panel replay_map_panel(const std::string& title, const ReplayResult& result);

/// Both of one replay.
std::vector<Figure> replay_figures(const std::string& name, const ReplayResult& result);

}  // namespace credence::internal
