#pragma once

#include <span>

#include "analysis/studies/rank_map.h"
#include "reports/document/report_table.h"
#include "reports/figures/figure.h"
#include "reports/render/json_numbers.h"

/// @file
/// The map of rank ΔP against rank O: its counts, the cells in which eq. (22) errs, and its figure.

namespace credence::internal {

/// Which condition says where P stays bounded.
ReportAnswer rank_map_answer(std::span<const RankMapCell> cells);

/// One row for each observability and range: how many cells, how many bounded, who errs.
ReportTable rank_map_table(std::span<const RankMapCell> cells, double confidence);

/// The cells in which eq. (22), or the exact condition, says other than was measured; seeds together.
ReportTable rank_map_disagreements(std::span<const RankMapCell> cells);

/// A panel for each observability and range: measured growth, both boundaries, and where eq. (22) errs.
Figure rank_map_figure(std::span<const RankMapCell> cells);

/// The counts and every cell.
Json rank_map_json(std::span<const RankMapCell> cells, double confidence);

}  // namespace credence::internal
