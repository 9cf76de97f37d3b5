#include "datasets/logs/run_errors.h"

#include <algorithm>
#include <cmath>

#include "core/nan.h"

namespace credence::internal {

RunErrors::RunErrors(const RunLayout& layout) {
  for (std::size_t i = 0; i < std::min(kStates, layout.states.size()); ++i) {
    states.push_back({layout.states[i], unit_of_states(layout, {static_cast<Index>(i)}), {}, {}});
  }
}

void RunErrors::add(const Step& next) {
  if (next.states.empty() || !next.problem.empty()) return;
  step.push_back(static_cast<double>(next.step));
  for (State& state : states) {
    state.error.push_back(kNaN);
    state.sigma.push_back(kNaN);
  }
  for (std::size_t i = 0; i < next.states.size(); ++i) {
    const auto state = static_cast<std::size_t>(next.states[i]);
    const auto at = static_cast<Index>(i);
    if (state >= states.size() || at >= next.error.size() || at >= next.P.rows()) continue;
    states[state].error.back() = next.error(at);
    states[state].sigma.back() = next.P(at, at) >= 0.0 ? std::sqrt(next.P(at, at)) : kNaN;
  }
}

void FirstRunSink::begin_run(const RunLayout& layout) {
  if (++runs_ == 1) first_ = RunErrors(layout);
  ForwardingSink::begin_run(layout);
}

void FirstRunSink::add(const Step& step) {
  if (runs_ == 1) first_.add(step);
  ForwardingSink::add(step);
}

}  // namespace credence::internal
