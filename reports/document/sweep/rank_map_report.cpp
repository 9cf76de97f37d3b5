#include "reports/document/sweep/rank_map_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/nan.h"

namespace credence::internal {
namespace {

std::string observability_text(Observability o) {
  return o == Observability::partial ? "partial" : "anchored";
}

std::string range_text(InflationRange range) {
  switch (range) {
    case InflationRange::generic: return "anywhere";
    case InflationRange::map: return "in the map";
    case InflationRange::with_vehicle: return "with the vehicle's noise";
    case InflationRange::difference: return "differences of landmarks";
  }
  return "";
}

TableCell bounded_text(int bounded, int seeds) {
  if (bounded != 0 && bounded != seeds) return fmt::format("{} bounded", bounded);
  return bounded > 0 ? "bounded" : "unbounded";
}

TableCell error_count(int errors) {
  return errors == 0 ? TableCell("0", CellTone::good) : TableCell(std::to_string(errors), CellTone::caution);
}

/// What the seeds of one place in the map have in common.
struct Place {
  int seeds = 0, bounded = 0, predicted = 0, paper = 0;
  int exact_errs = 0, paper_errs = 0;
  double growth = 0.0;  // sum over the seeds

  void add(const RankMapCell& cell) {
    ++seeds;
    bounded += cell.bounded ? 1 : 0;
    predicted += cell.predicted ? 1 : 0;
    paper += cell.paper ? 1 : 0;
    exact_errs += cell.predicted != cell.bounded ? 1 : 0;
    paper_errs += cell.paper != cell.bounded ? 1 : 0;
    growth += cell.growth_per_step;
  }
  double mean_growth() const { return growth / seeds; }
};

/// (rank O, rank ΔP) → place.
using Places = std::map<std::pair<Index, Index>, Place>;
using Group = std::pair<Observability, InflationRange>;

std::map<Group, Places> grouped(std::span<const RankMapCell> cells) {
  std::map<Group, Places> groups;
  for (const RankMapCell& cell : cells) {
    groups[{cell.observability, cell.range}][{cell.observability_rank, cell.inflation_rank}].add(cell);
  }
  return groups;
}

/// The upper edge of the bounded cells as a staircase over rank O; nothing where no cell lies above it.
Series boundary(FigureText label, ColourRole role, const Places& places, int Place::*says_bounded) {
  std::map<Index, std::pair<Index, Index>> columns;  // rank O → largest bounded rank ΔP, largest rank ΔP
  for (const auto& [ranks, place] : places) {
    auto& [bounded, top] = columns.try_emplace(ranks.first, -1, -1).first->second;
    top = std::max(top, ranks.second);
    if (place.*says_bounded == place.seeds) bounded = std::max(bounded, ranks.second);
  }
  FigureData x, y;
  for (const auto& [rank_O, column] : columns) {
    const double height = column.first < column.second ? static_cast<double>(column.first) + 0.5 : kNaN;
    for (const double side : {-0.5, 0.5}) {
      x.push_back(static_cast<double>(rank_O) + side);
      y.push_back(height);
    }
  }
  return line_series(std::move(label), role, std::move(x), std::move(y));
}

Series growth_cells(const Places& places, Index largest_O, Index largest_P) {
  Matrix cells = Matrix::Constant(largest_P + 1, largest_O, kNaN);
  for (const auto& [ranks, place] : places) cells(ranks.second, ranks.first - 1) = place.mean_growth();
  return heat_series(index_axis(largest_O, 1), index_axis(largest_P + 1, 0), std::move(cells));
}

Panel panel_of(const Group& group, const Places& places, Index largest_O, Index largest_P, double growth) {
  Panel panel{.title = observability_text(group.first) + ", " + range_text(group.second),
              .x_label = "rank O",
              .y_label = "rank ΔP",
              .x_range = AxisRange{0.5, static_cast<double>(largest_O) + 0.5},
              .y_range = AxisRange{-0.5, static_cast<double>(largest_P) + 0.5},
              .colour_label = "growth of tr P (m² a step)",
              .colour_range = AxisRange{0.0, growth},
              .colour_scale = ColourScale::rising};  // white, its lower end, is bounded
  panel.series.push_back(growth_cells(places, largest_O, largest_P));
  const auto add_boundary = [&](const char* label, ColourRole role, int Place::*says_bounded) {
    Series series = boundary(label, role, places, says_bounded);
    if (std::all_of(series.y.begin(), series.y.end(), [](double y) { return std::isnan(y); })) return false;
    series.weight = 2.0;
    panel.series.push_back(std::move(series));
    return true;
  };
  add_boundary("exact condition: bounded below", ColourRole::exact, &Place::predicted);
  if (add_boundary("eq. (22): bounded below", ColourRole::truth, &Place::paper)) {
    panel.series.back().stroke = StrokeStyle::dashed;
  }
  FigureData x, y;
  for (const auto& [ranks, place] : places) {
    if (place.paper_errs == 0) continue;
    x.push_back(static_cast<double>(ranks.first));
    y.push_back(static_cast<double>(ranks.second));
  }
  if (!x.empty()) {
    panel.series.push_back(point_series("eq. (22) errs", ColourRole::truth, std::move(x), std::move(y)));
    panel.series.back().marker = MarkerShape::cross;
    panel.series.back().weight = 1.5;
  }
  return panel;
}

}  // namespace

ReportAnswer rank_map_answer(std::span<const RankMapCell> cells) {
  const auto exact =
      std::ranges::count_if(cells, [](const RankMapCell& c) { return c.predicted != c.bounded; });
  const auto paper = std::ranges::count_if(cells, [](const RankMapCell& c) { return c.paper != c.bounded; });
  const std::string exact_text = cells.size() == 1
                                     ? exact == 0 ? "is right in the one cell" : "errs in the one cell"
                                 : exact == 0 ? fmt::format("is right in all {} cells", cells.size())
                                              : fmt::format("errs in {} of {} cells", exact, cells.size());
  return {exact == 0 ? CellTone::good : CellTone::caution,
          fmt::format("The exact condition {} of the map; the paper's eq. (22), rank ΔP ≤ rank O, errs in {}",
                      exact_text, paper)};
}

ReportTable rank_map_table(std::span<const RankMapCell> cells, double confidence) {
  ReportTable table{.title = "The map of ranks",
                    .columns = {{"observability", ColumnAlign::words},
                                {"range of ΔP", ColumnAlign::words},
                                {"cells"},
                                {"bounded"},
                                {"exact condition errs"},
                                {"eq. (22) errs"},
                                {"largest NEES / expected"},
                                {"errors outside P"}}};
  for (const RankMapSummary& s : summarise(cells, confidence)) {
    table.add({observability_text(s.observability), range_text(s.range), s.cells, s.bounded,
               error_count(s.exact_errs), error_count(s.paper_errs), s.largest_nees_ratio,
               error_count(s.errors_outside)});
  }
  table.notes = {
      "bounded: measured by the covariance recursion, doubled to 2^21 steps. Both conditions are compared "
      "with it.",
      "errors outside P: cells whose mean NEES over the runs is above its expected value beyond chance, all "
      "cells of the map taken together (Holm). An inflated filter should have none."};
  return table;
}

ReportTable rank_map_disagreements(std::span<const RankMapCell> cells) {
  ReportTable table{.title = "Where a condition errs",
                    .columns = {{"observability", ColumnAlign::words},
                                {"range of ΔP", ColumnAlign::words},
                                {"rank O"},
                                {"rank ΔP"},
                                {"seeds"},
                                {"measured", ColumnAlign::words},
                                {"growth (m² a step)"},
                                {"exact condition", ColumnAlign::words},
                                {"eq. (22)", ColumnAlign::words}}};
  for (const auto& [group, places] : grouped(cells)) {
    for (const auto& [ranks, place] : places) {
      if (place.paper_errs == 0 && place.exact_errs == 0) continue;
      table.add({observability_text(group.first), range_text(group.second), ranks.first, ranks.second,
                 place.seeds, bounded_text(place.bounded, place.seeds), place.mean_growth(),
                 bounded_text(place.predicted, place.seeds), bounded_text(place.paper, place.seeds)});
    }
  }
  return table;
}

Figure rank_map_figure(std::span<const RankMapCell> cells) {
  Index largest_O = 1, largest_P = 1;
  double growth = 0.0;
  for (const RankMapCell& cell : cells) {
    largest_O = std::max(largest_O, cell.observability_rank);
    largest_P = std::max(largest_P, cell.inflation_rank);
  }
  const std::map<Group, Places> groups = grouped(cells);
  for (const auto& [group, places] : groups) {
    for (const auto& [ranks, place] : places) growth = std::max(growth, place.mean_growth());
  }
  const int panels = static_cast<int>(groups.size());
  Figure figure{.name = "rank-map",
                .caption =
                    "How fast the covariance grows for a constant inflation ΔP, measured by the covariance "
                    "recursion; white cells are bounded, grey ones do not exist. Solid line: the exact "
                    "condition; dashed: the paper's eq. (22), rank ΔP ≤ rank O; no line where nothing is "
                    "unbounded. Crosses: cells in which eq. (22) errs: it says bounded and P grows, or the "
                    "other way round.",
                .rows = (panels + 1) / 2,
                .cols = panels > 1 ? 2 : 1};
  for (const auto& [group, places] : groups) {
    figure.panels.push_back(panel_of(group, places, largest_O, largest_P, growth > 0.0 ? growth : 1.0));
  }
  return figure;
}

Json rank_map_json(std::span<const RankMapCell> cells, double confidence) {
  Json groups = json_list(summarise(cells, confidence), [](const RankMapSummary& s) -> Json {
    return {{"observability", to_string(s.observability)},
            {"inflation_range", to_string(s.range)},
            {"cells", s.cells},
            {"bounded", s.bounded},
            {"exact_errs", s.exact_errs},
            {"paper_errs", s.paper_errs},
            {"errors_outside", s.errors_outside},
            {"largest_nees_ratio", s.largest_nees_ratio}};
  });
  Json list = json_list(cells, [](const RankMapCell& c) -> Json {
    return {{"observability", to_string(c.observability)},
            {"inflation_range", to_string(c.range)},
            {"landmarks", c.landmarks},
            {"inflation_rank", c.inflation_rank},
            {"observability_rank", c.observability_rank},
            {"measured_bounded", c.bounded},
            {"growth_exponent", c.growth_exponent},
            {"growth_per_step", c.growth_per_step},
            {"predicted_bounded", c.predicted},
            {"paper_condition_holds", c.paper},
            {"nees_ratio", c.nees_ratio},
            {"error_growth", c.error_growth}};
  });
  return {{"groups", std::move(groups)}, {"cells", std::move(list)}};
}

}  // namespace credence::internal
