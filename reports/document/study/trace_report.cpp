#include "reports/document/study/trace_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "core/append_item.h"
#include "core/number_text.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/shown_unit.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

/// The states whose errors a table of steps has room for: the vehicle, or the first ones.
std::vector<Index> shown_states(const Scenario& scenario, const RunTrace& trace) {
  if (world_of(scenario).figure != RunFigure::states) return trace.layout.blocks.front().states;
  std::vector<Index> states(std::min<std::size_t>(trace.layout.states.size(), 3));
  std::iota(states.begin(), states.end(), Index{0});
  return states;
}

ShownUnit unit_of_state(const RunTrace& trace, Index state) {
  return shown_unit(unit_of_states(trace.layout, {state}));
}

/// The words above them.
std::string errors_title(const Scenario& scenario, const RunTrace& trace) {
  switch (world_of(scenario).figure) {
    case RunFigure::line_slam: return "vehicle error (m) ± 2σ";
    case RunFigure::plane_slam: return "error of x (m), y (m), θ (°) ± 2σ";
    case RunFigure::states: break;
  }
  std::vector<std::string> names;
  for (const Index i : shown_states(scenario, trace)) {
    names.push_back(trace.layout.states[static_cast<std::size_t>(i)] +
                    unit_in_brackets(unit_of_state(trace, i).name));
  }
  return fmt::format("error of {} ± 2σ", fmt::join(names, ", "));
}

/// Errors, each with its 2σ.
std::string errors_text(const RunTrace& trace, std::span<const Index> states, const TraceStep& s) {
  std::string text;
  for (const Index i : states) {
    const double scale = unit_of_state(trace, i).scale;
    append_item(text, fmt::format("{} ± {}", number_text(scale * s.error[i], 3),
                                  number_text(scale * 2.0 * std::sqrt(s.P(i, i)), 3)));
  }
  return text;
}

/// Without degrees of freedom there is none.
TableCell normalised_cell(double value, Index dof) { return dof > 0 ? TableCell(value) : TableCell("–"); }

std::string trace_json(const Scenario& scenario, const RunTrace& trace) {
  Json j;
  j["schema"] = kSchema;
  j["scenario"] = Json::parse(scenario_to_json(scenario));
  j["seed"] = scenario.study.seed;
  j["run"] = trace.run;
  j["outcome"] = to_string(trace.outcome);
  j["landmarks"] = trace.steps.back().landmarks;
  j["landmark_positions"] = json_matrix(trace.landmark_positions.transpose());
  j["anchor_positions"] = json_matrix(trace.anchor_positions.transpose());
  Json steps = Json::array();
  for (std::size_t k = 0; k < trace.steps.size(); ++k) {
    const TraceStep& s = trace.steps[k];
    steps.push_back({{"step", k},
                     {"landmarks", s.landmarks},
                     {"truth", json_vector(s.truth)},
                     {"estimate", json_vector(s.estimate)},
                     {"covariance", json_matrix(s.P)},
                     {"measurement", json_vector(s.z)},
                     {"innovation", json_vector(s.innovation())},
                     {"innovation_covariance", json_matrix(s.S())},
                     {"gain", json_matrix(s.K)},
                     {"nees", s.nees},
                     {"nees_dof", s.nees_dof},
                     {"nis", s.nis},
                     {"nis_dof", s.nis_dof}});
  }
  j["steps"] = std::move(steps);
  j["null_reason"] = "null: not a finite number";
  return text_of_json(j);
}

ReportTable trace_table(const Scenario& scenario, const RunTrace& trace) {
  using enum ColumnAlign;
  constexpr std::size_t kRows = 20;
  ReportTable table{
      .title = fmt::format("{}, run {}, seed {}: {}", scenario.name, trace.run, scenario.study.seed,
                           to_string(trace.outcome)),
      .columns = {{"step"}, {errors_title(scenario, trace), words}, {"NEES"}, {"dof"}, {"NIS"}, {"dof"}}};
  const std::vector<Index> states = shown_states(scenario, trace);
  const std::size_t last = trace.steps.size() - 1;
  const std::size_t every = std::max<std::size_t>(1, (last + kRows - 1) / kRows);
  for (std::size_t k = 0; k <= last; k += (k + every <= last || k == last) ? every : last - k) {
    const TraceStep& s = trace.steps[k];
    table.add({k, errors_text(trace, states, s), normalised_cell(s.nees, s.nees_dof), s.nees_dof,
               normalised_cell(s.nis, s.nis_dof), s.nis_dof});
  }
  if (every > 1)
    table.notes = {fmt::format("every {} of {} steps; all of them with --format json",
                               ordinal(static_cast<std::int64_t>(every)), last)};
  return table;
}

}  // namespace

Document trace_document(const Scenario& scenario, const RunTrace& trace) {
  Document document(scenario.name);
  document.json = [scenario, trace] { return trace_json(scenario, trace); };
  document.brief.emplace_back(trace_table(scenario, trace));
  return document;
}

}  // namespace credence::internal
