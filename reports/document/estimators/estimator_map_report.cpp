#include "reports/document/estimators/estimator_map_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/estimators/estimator_report.h"
#include "reports/document/sweep/swept_values.h"

namespace credence::internal {
namespace {

const MeanInterval& map_nees(const EstimatorMap& map, std::size_t point, std::size_t e) {
  return map.studies[point].rows[e].nees[static_cast<std::size_t>(EstimatorBlock::pose)];
}

/// What is judged: any states are no pose.
const char* map_nees_words(const EstimatorMap& map) {
  return map.studies.front().has_vehicle ? "Pose NEES" : "NEES";
}

/// "pose" or, where there is none, "state".
const char* judged(const EstimatorMap& map) { return map.studies.front().has_vehicle ? "pose" : "state"; }

CellTone tone_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::consistent: return CellTone::good;
    case Verdict::pessimistic: return CellTone::caution;
    case Verdict::undecided: return CellTone::plain;
    default: return CellTone::alarm;
  }
}

/// "Pessimistic: intersection at 9, ekf at 1", by the points where each estimator has this verdict; empty
/// where none.
std::string counted_text(const EstimatorMap& map, Verdict verdict, const char* word) {
  std::string text;
  for (std::size_t e = 0; e < map.names.size(); ++e) {
    int count = 0;
    for (std::size_t p = 0; p < map.plan.points.size(); ++p) {
      if (map.studies[p].rows[e].failures.empty() && map.verdict(p, e) == verdict) ++count;
    }
    if (count > 0) append_item(text, fmt::format("{} at {}", map.names[e], count));
  }
  return text.empty() ? text : fmt::format("{}: {}.", word, text);
}

std::vector<FigureText> value_names(const SweepAxis& axis) {
  std::vector<FigureText> names;
  for (const ScalarValue& value : axis.values) names.emplace_back(swept_text(value));
  return names;
}

/// Which value of an axis a point has.
Index place_on(const SweepAxis& axis, const ScalarValue& value) {
  return std::ranges::find(axis.values, value) - axis.values.begin();
}

AxisRange around(Index count) { return {0.5, static_cast<double>(count) + 0.5}; }

/// Axes of the plan are two, each point is a cell: coloured by the cost of the cheapest, with its name.
Panel cheapest_panel(const EstimatorMap& map) {
  const SweepAxis &across = map.plan.axes[0], &up = map.plan.axes[1];
  const auto columns = std::ssize(across.values), rows = std::ssize(up.values);
  Panel panel{.title = "The cheapest that stays consistent",
              .x_label = across.path,
              .y_label = up.path,
              .x_range = around(columns),
              .y_range = around(rows),
              .x_names = value_names(across),
              .y_names = value_names(up),
              .colour_label = "its time per step (µs)",
              .log_colour = true};
  Matrix cells = Matrix::Constant(rows, columns, kNaN);
  FigureData x, y;
  std::vector<FigureText> names;
  for (std::size_t p = 0; p < map.plan.points.size(); ++p) {
    const Index column = place_on(across, map.plan.points[p].values[0]);
    const Index row = place_on(up, map.plan.points[p].values[1]);
    const auto best = map.cheapest(p);
    if (best) cells(row, column) = 1e6 * map.seconds_per_step[*best];
    x.push_back(static_cast<double>(column) + 0.6);
    y.push_back(static_cast<double>(row) + 0.9);
    names.emplace_back(best ? map.names[*best] : "none");
  }
  panel.series.push_back(heat_series(index_axis(columns), index_axis(rows), std::move(cells)));
  panel.series.push_back(text_series(ColourRole::neutral, std::move(x), std::move(y), std::move(names)));
  return panel;
}

/// Estimators over the values of the first axis: the largest pose NEES over the values of the others.
Panel nees_panel(const EstimatorMap& map) {
  const SweepAxis& across = map.plan.axes[0];
  const auto columns = std::ssize(across.values), rows = std::ssize(map.names);
  std::vector<FigureText> names;
  for (const std::string& name : map.names) names.emplace_back(name);
  Panel panel{.title = fmt::format("{} over dof", map_nees_words(map)),
              .x_label = across.path,
              .y_label = "estimator",
              .x_range = around(columns),
              .y_range = around(rows),
              .x_names = value_names(across),
              .y_names = std::move(names),
              .colour_label = fmt::format("{} over dof", map_nees_words(map)),
              .log_colour = true};
  Matrix cells = Matrix::Constant(rows, columns, kNaN);
  for (std::size_t p = 0; p < map.plan.points.size(); ++p) {
    const Index column = place_on(across, map.plan.points[p].values[0]);
    for (std::size_t e = 0; e < map.names.size(); ++e) {
      if (map.studies[p].rows[e].runs == 0) continue;
      double& cell = cells(static_cast<Index>(e), column);
      cell = std::isnan(cell) ? map_nees(map, p, e).mean : std::max(cell, map_nees(map, p, e).mean);
    }
  }
  panel.series.push_back(heat_series(index_axis(columns), index_axis(rows), std::move(cells)));
  return panel;
}

ReportAnswer estimator_map_answer(const EstimatorMap& map) {
  std::vector<int> enough(map.names.size(), 0);
  int none = 0;
  for (std::size_t p = 0; p < map.plan.points.size(); ++p) {
    const auto best = map.cheapest(p);
    ++(best ? enough[*best] : none);
  }
  std::string text;
  for (std::size_t e = 0; e < enough.size(); ++e) {
    if (enough[e] == 0) continue;
    append_item(text, fmt::format("{} at {}", map.names[e], enough[e]));
  }
  if (none > 0) append_item(text, fmt::format("none at {}", none));
  return {none > 0 ? CellTone::caution : CellTone::good,
          fmt::format("The cheapest estimator whose {} stays consistent, of {}: {}", judged(map),
                      counted(map.plan.points.size(), "point"), text)};
}

/// What is said of the ideal filter where it is one of those compared, or the world has none.
const char* ideal_words(const EstimatorMap& map) {
  if (std::ranges::find(map.names, "ideal") != map.names.end())
    return " ideal is not asked: no filter that could be built.";
  const EstimatorOffer* offer = world_of(map.studies.front().scenario).estimators;
  std::vector<std::string_view> offered;
  if (offer != nullptr) offered = offer->names(nullptr);
  const bool has_ideal = std::ranges::find(offered, "ideal") != offered.end();
  return has_ideal ? "" : " The world has no ideal filter.";
}

/// How far from 1 the means may be that are called consistent, by their intervals: as far as runs are few.
std::string reach_of_cheapest(const EstimatorMap& map) {
  double lower = HUGE_VAL, upper = 0.0;
  for (std::size_t p = 0; p < map.plan.points.size(); ++p) {
    const auto best = map.cheapest(p);
    if (!best || std::isnan(map_nees(map, p, *best).lower)) continue;
    lower = std::min(lower, map_nees(map, p, *best).lower);
    upper = std::max(upper, map_nees(map, p, *best).upper);
  }
  return upper == 0.0 ? ""
                      : fmt::format(
                            "Of those that are named it may be anywhere from {} to {}, by their intervals: "
                            "more runs narrow that.",
                            number_text(lower, 3), number_text(upper, 3));
}

/// One row for each point, titled by the answer: the cheapest, and the pose NEES of all.
ReportTable estimator_map_table(const EstimatorMap& map) {
  ReportTable table{.title = estimator_map_answer(map).text};
  for (const SweepAxis& axis : map.plan.axes) table.columns.push_back({axis.path, ColumnAlign::words});
  table.columns.push_back({"cheapest", ColumnAlign::words});
  for (const std::string& name : map.names) table.columns.push_back({name});
  for (std::size_t p = 0; p < map.plan.points.size(); ++p) {
    std::vector<TableCell> row;
    for (const ScalarValue& value : map.plan.points[p].values) row.emplace_back(swept_text(value));
    const auto best = map.cheapest(p);
    row.push_back(best ? TableCell(map.names[*best], CellTone::good) : TableCell("none", CellTone::alarm));
    for (std::size_t e = 0; e < map.names.size(); ++e) {
      const auto failed = std::ssize(map.studies[p].rows[e].failures);
      const CellTone tone = failed > 0 ? CellTone::alarm : tone_of(map.verdict(p, e));
      row.emplace_back(
          failed > 0 ? fmt::format("{} failed", failed) : number_text(map_nees(map, p, e).mean, 3), tone);
    }
    table.rows.push_back(std::move(row));
  }
  std::string costs;
  for (std::size_t e = 0; e < map.names.size(); ++e) {
    costs +=
        fmt::format("{}{} {}", e == 0 ? "" : ", ", map.names[e], duration_text(map.seconds_per_step[e], 2));
  }
  table.notes = {fmt::format(
      "{} over dof of {} runs a point. Stays consistent: no run failed, and its mean is seen neither "
      "above {:g} (optimistic) nor below 1/{:g} (pessimistic), by a test of its own at {:g} %, with an "
      "interval "
      "from 1/2 to 2 at most (else undecided).{}",
      map_nees_words(map), map.studies.front().runs, kToleratedFactor, kToleratedFactor,
      100.0 * (1.0 - map.studies.front().scenario.study.confidence), ideal_words(map))};
  if (std::string reach = reach_of_cheapest(map); !reach.empty()) table.notes.push_back(std::move(reach));
  for (const auto& [verdict, word] : {std::pair(Verdict::optimistic, "Optimistic, without a failed run"),
                                      {Verdict::pessimistic, "Pessimistic"},
                                      {Verdict::undecided, "Undecided"}}) {
    if (std::string text = counted_text(map, verdict, word); !text.empty())
      table.notes.push_back(std::move(text));
  }
  table.notes.push_back(
      fmt::format("Time of a step, mean over the points: {}. Times within {:g} % of the least are the same, "
                  "and of these the "
                  "first is named.",
                  costs, 100.0 * (kSameCost - 1.0)));
  for (std::string& note : left_out_notes(map.left_out)) table.notes.push_back(std::move(note));
  return table;
}

/// With two axes, the cheapest at each point by its cost, named; pose NEES of every estimator along the first
/// axis, over the worst of the other values.
std::vector<Figure> estimator_map_figures(const EstimatorMap& map) {
  std::vector<Figure> figures;
  if (map.plan.axes.empty() || map.plan.mode != SweepMode::grid) return figures;
  if (map.plan.axes.size() == 2) {
    figures.push_back({.name = "cheapest",
                       .caption =
                           "At each point the cheapest estimator that stays consistent, coloured by its time "
                           "per step; grey: none does.",
                       .panels = {cheapest_panel(map)}});
  }
  constexpr double kLeast = 18.0, kLine = 1.5;  // of a name
  figures.push_back({.name = "nees",
                     .caption = fmt::format(
                         "{} over dof of each estimator, mean over the runs; of several points the largest; "
                         "grey: no run ended well.",
                         map_nees_words(map)),
                     .panels = {nees_panel(map)},
                     .row_height = std::max(kLeast, kLine * static_cast<double>(map.names.size()))});
  return figures;
}

std::string estimator_map_json(const EstimatorMap& map) {
  Json json;
  json["schema"] = kSchema;
  json["tolerated_factor"] = kToleratedFactor;
  json["estimators"] = Json::array();
  for (std::size_t e = 0; e < map.names.size(); ++e) {
    json["estimators"].push_back(
        {{"estimator", map.names[e]}, {"seconds_per_step", map.seconds_per_step[e]}});
  }
  json["left_out"] = left_out_json(map.left_out);
  json["points"] = Json::array();
  for (std::size_t p = 0; p < map.plan.points.size(); ++p) {
    const auto best = map.cheapest(p);
    Json point{{"values", swept_json(map.plan, map.plan.points[p])},
               {"cheapest", best ? Json(map.names[*best]) : Json(nullptr)}};
    point["estimators"] = Json::array();
    for (std::size_t e = 0; e < map.names.size(); ++e) {
      const DirectedPValues& beyond = map.studies[p].rows[e].beyond_tolerance;
      point["estimators"].push_back({{"estimator", map.names[e]},
                                     {"verdict", to_string(map.verdict(p, e))},
                                     {"failed", map.studies[p].rows[e].failures.size()},
                                     {"optimistic_p_value", beyond.optimistic},
                                     {"pessimistic_p_value", beyond.pessimistic}});
    }
    point["study"] = Json::parse(estimator_json(map.studies[p]));
    json["points"].push_back(std::move(point));
  }
  json["null_reason"] = "no estimator stays consistent, or no run ended well";
  return text_of_json(json);
}

}  // namespace

Document estimator_map_document(const EstimatorMap& map) {
  Document document("Estimators over " + map.plan.name, "The cheapest that stays consistent, by Credence");
  document.answer = estimator_map_answer(map);
  document.json = [map] { return estimator_map_json(map); };

  const ReportTable table = estimator_map_table(map);
  document.brief.emplace_back(table);

  document.section("Where which is enough");
  document.table(table);
  document.figures(estimator_map_figures(map));
  document.section("Settings");
  document.verbatim(canonical_toml(map.plan));
  return document;
}

}  // namespace credence::internal
