#include "montecarlo/worlds/plugged/plugged_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "core/control_characters.h"
#include "core/record/nees_solver.h"
#include "core/record/state_name.h"
#include "montecarlo/worlds/plugged/plugged_concepts.h"

namespace credence::internal {
namespace {

/// Names and units stand in the header of a CSV log.
void require_columns(std::string_view what, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    if (text.find_first_of(",\"") == std::string::npos && !has_control_character(text)) continue;
    throw std::invalid_argument(
        fmt::format("{}: {:?} has a comma, a quote or a control character, which a column's name cannot have",
                    what, text));
  }
}

/// Verdicts are told by the names of their states.
void require_names(const std::vector<std::string>& states) {
  std::set<std::string_view> seen;
  for (const std::string& state : states) {
    if (state.empty()) throw std::invalid_argument("states: a name is empty");
    if (!seen.insert(state).second) {
      throw std::invalid_argument(
          fmt::format("states: '{}' is there twice; accepted are names that differ", state));
    }
  }
}

}  // namespace

RunLayout model_layout(const std::vector<std::string>& states,
                       const std::vector<std::pair<std::string, Index>>& sensors) {
  RunLayout layout{.states = states};
  for (const auto& [name, dim] : sensors) layout.sensors.push_back({.name = name, .dim = dim});
  return completed(std::move(layout));
}

RunLayout completed(RunLayout layout) {
  const std::size_t n = layout.states.size();
  if (layout.angles.empty()) layout.angles.assign(n, false);
  if (layout.angles.size() != n) {
    throw std::invalid_argument(fmt::format(
        "layout(): {} angles for {} states; accepted is one for each, or none", layout.angles.size(), n));
  }
  if (!layout.units.empty() && layout.units.size() != n) {
    throw std::invalid_argument(fmt::format(
        "layout(): {} units for {} states; accepted is one for each, or none", layout.units.size(), n));
  }
  for (std::size_t i = 0; i < n; ++i) {
    StateName state = state_name(layout.states[i]);
    layout.states[i] = std::move(state.name);
    layout.angles[i] = layout.angles[i] || state.angle;
    if (state.unit.empty()) continue;
    layout.units.resize(n);
    if (!layout.units[i].empty() && layout.units[i] != state.unit) {
      throw std::invalid_argument(fmt::format("layout(): state '{}' is in '{}', and by its name in '{}'",
                                              layout.states[i], layout.units[i], state.unit));
    }
    layout.units[i] = std::move(state.unit);
  }
  require_names(layout.states);
  require_columns("states", layout.states);
  require_columns("units", layout.units);
  require_radians(layout, "layout(): ");
  for (const Block& block : layout.blocks) {
    for (const Index state : block.states) {
      if (state >= 0 && static_cast<std::size_t>(state) < n) continue;
      throw std::invalid_argument(
          fmt::format("layout(): block '{}' has state {} of {}, which count from 0", block.name, state, n));
    }
  }
  if (layout.blocks.empty()) add_named_blocks(layout);
  for (Sensor& sensor : layout.sensors) {
    if (sensor.piece == 0) sensor.piece = sensor.dim;
  }
  return layout;
}

void normalise_step(TraceStep& step) {
  NeesSolver solver;
  const NeesValue nees = solver.solve(step.error, step.P);
  step.nees = nees.value;
  step.nees_dof = std::max<Index>(0, nees.dof);
  step.nis = 0.0;
  step.nis_dof = 0;
  for (const Innovation& innovation : step.innovations) {
    if (innovation.nu.size() == 0) continue;
    const NeesValue nis = solver.solve(innovation.nu, innovation.S);
    step.nis += nis.value;
    step.nis_dof += std::max<Index>(0, nis.dof);
  }
}

namespace {

/// Where the states of a block stand in a step; empty where one of them is not there.
std::vector<Index> places_of(const Block& block, const TraceStep& step, const RunLayout& layout) {
  const bool all = step.error.size() == std::ssize(layout.states) && std::ranges::is_sorted(step.states);
  if (all) return block.states;
  std::vector<Index> places;
  for (const Index state : block.states) {
    const auto found = std::ranges::find(step.states, state);
    if (found == step.states.end()) return {};
    places.push_back(found - step.states.begin());
  }
  return places;
}

/// What the parts of the layout say of a vehicle: its place, heading and pose.
void add_parts(const RunLayout& layout, const TraceStep& step, NeesSolver& solver, StepStatistics& s,
               RunSum& vehicle) {
  for (const Block& block : layout.blocks) {
    if (block.part != Part::position && block.part != Part::heading && block.part != Part::pose) continue;
    const std::vector<Index> places = places_of(block, step, layout);
    if (places.empty()) continue;
    const auto squared_error = [&] { return step.error(places).squaredNorm(); };
    const auto trace = [&] { return step.P.diagonal()(places).sum(); };
    if (block.part == Part::position) {
      s[Quantity::trace_vehicle].add(trace());
      s[Quantity::position_error_squared].add(squared_error());
    } else if (block.part == Part::heading) {
      s[Quantity::heading_variance].add(trace());
      s[Quantity::heading_error_squared].add(squared_error());
    } else if (block.part == Part::pose) {
      const NeesValue nees = solver.solve(step.error(places), step.P(places, places));
      if (nees.dof <= 0) continue;
      s[Quantity::vehicle_nees].add(nees.value);
      vehicle.add(nees.value, nees.dof);
    }
  }
}

}  // namespace

StudyStatistics VisitedExperiment::play(std::int64_t first_run, std::int64_t runs,
                                        ChunkObserver* observer) const {
  struct Run {
    RunSum sum, vehicle;
    std::int64_t last = 0;
  };
  StudyStatistics statistics;
  statistics.steps.resize(static_cast<std::size_t>(steps_));
  statistics.runs = runs;
  statistics.reserve_runs(runs);
  NeesSolver solver;
  const std::int64_t end = first_run + runs, most = runs_side_by_side();
  for (std::int64_t first = first_run; first < end; first += most) {
    std::vector<Run> side(static_cast<std::size_t>(std::min(most, end - first)));
    if (observer != nullptr) observer->begin_runs(std::ssize(side));
    const std::vector<Outcome> outcomes =
        visit_runs(first, std::ssize(side), [&](std::int64_t number, const TraceStep& step) {
          const auto i = static_cast<std::size_t>(number - first);
          Run& run = side[i];
          run.last = step.step;
          if (step.step == 0 || step.outcome != Outcome::ok) return;
          if (observer != nullptr) observer->add(step, i);
          StepStatistics& s = statistics.steps[static_cast<std::size_t>(step.step) - 1];
          s[Quantity::trace].add(step.P.trace());
          if (step.nees_dof > 0) s[Quantity::nees].add(step.nees);
          if (step.nis_dof > 0) s[Quantity::nis].add(step.nis);
          s.nees_dof += step.nees_dof;
          s.nis_dof += step.nis_dof;
          run.sum.add(step.nees, step.nees_dof);
          add_parts(layout(), step, solver, s, run.vehicle);
        });
    for (std::size_t i = 0; i < side.size(); ++i) {
      if (observer != nullptr) observer->end_run(outcomes[i], side[i].last, i);
      if (outcomes[i] == Outcome::ok) {
        side[i].sum.add_to(statistics.nees_of_runs);
        side[i].vehicle.add_to(statistics.vehicle_nees_of_runs);
      } else {
        statistics.failures.push_back({first + static_cast<std::int64_t>(i), side[i].last, outcomes[i]});
      }
    }
  }
  return statistics;
}

}  // namespace credence::internal
