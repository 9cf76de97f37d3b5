#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/replay_result.h"
#include "reports/figure.h"
#include "reports/report_table.h"

namespace credence {

/// The document of `credence replay` (docs/formats.md).
std::string replay_json(const ReplayResult& result);

/// The numbers of a replay with their counts and what they can be compared with.
ReportTable replay_table(const ReplayResult& result);

/// Path and map over the reference and the survey; errors of the vehicle with 2σ; NIS over time; landmark
/// standard deviations, gains of the landmarks.
std::vector<Figure> replay_figures(const ReplayResult& result);

/// Writes DIR/index.html and the figures as PDF. Returns why figures could not be drawn. Throws OutputError.
std::vector<std::string> write_replay_report(const std::filesystem::path& directory,
                                             const ReplayResult& result);

}  // namespace credence
