#include "datasets/arrays/array_mistakes.h"

#include <algorithm>

#include "core/stop_point.h"
#include "datasets/arrays/array_reader.h"
#include "datasets/logs/conventions/angle_units.h"
#include "datasets/logs/conventions/innovation_repeats.h"
#include "datasets/logs/conventions/step_conventions.h"
#include "datasets/logs/conventions/swapped_axes.h"

namespace credence::internal {
namespace {

/// A state alone, without the innovations, which nothing is asked of here.
ArrayRuns states_of(const ArrayRuns& arrays) {
  ArrayRuns states = arrays;
  states.layout.sensors.clear();
  for (ArrayRun& run : states.runs) run.innovations.clear();
  return states;
}

constexpr std::int64_t kRows = 4096;

/// Of the first rows, since one is compared with the next.
void look_at_innovations(const ArrayRuns& arrays, LogSink& sink) {
  if (arrays.layout.sensors.empty()) return;
  InnovationRepeats repeats(sink);
  ArrayReader reader(arrays);
  Step step;
  std::int64_t seen = 0;
  for (std::int64_t run = 0; run < std::ssize(arrays.runs) && seen < kRows; ++run) {
    repeats.begin_run(arrays.layout);
    const std::int64_t steps = arrays.runs[static_cast<std::size_t>(run)].steps;
    for (std::int64_t row = 0; row < steps && seen < kRows; ++row, ++seen) {
      reader.read(run, row, step);
      repeats.add(step);
    }
  }
  repeats.finish();
}

/// Of runs in one array; those of a list have no axis that could be another one.
std::string swapped_axes(const ArrayRuns& states) {
  if (states.indexing != ArrayIndexing::stacked) return "";
  constexpr std::int64_t kRunsAndSteps = 128;  // all that is asked for
  SwappedAxes axes;
  ArrayReader reader(states);
  Step step;
  for (std::int64_t run = 0; run < std::min(kRunsAndSteps, std::ssize(states.runs)); ++run) {
    stop_point();
    axes.begin_run();
    const std::int64_t steps = states.runs[static_cast<std::size_t>(run)].steps;
    for (std::int64_t row = 0; row < std::min(kRunsAndSteps, steps); ++row) {
      reader.read(run, row, step);
      axes.add(step);
    }
  }
  return axes.says();
}

}  // namespace

ArrayMistakes array_mistakes(const ArrayRuns& arrays) {
  ArrayMistakes mistakes;
  SaidSink sink(mistakes.said);
  look_at_innovations(arrays, sink);
  if (!arrays.layout.has_truth) return mistakes;
  const ArrayRuns states = states_of(arrays);
  mistakes.swapped_axes = swapped_axes(states);
  std::int64_t rows = 0;
  bool has_estimates = false;
  for (const ArrayRun& run : states.runs) {
    rows += run.steps;
    has_estimates = has_estimates || run.estimate.data != nullptr;
  }
  std::int64_t stride = 1;
  while (rows / stride >= kRows) stride *= 2;
  AngleUnits units(sink);
  StepConventions conventions(units);
  ArrayReader reader(states);
  Step step;
  std::int64_t seen = 0;
  for (std::int64_t run = 0; run < std::ssize(states.runs); ++run) {
    conventions.begin_run(states.layout);
    for (std::int64_t row = 0; row < states.runs[static_cast<std::size_t>(run)].steps; ++row) {
      stop_point();
      if (seen++ % stride != 0 && !has_estimates) continue;
      reader.read(run, row, step);
      conventions.add(step);
    }
  }
  conventions.finish();
  units.finish();
  return mistakes;
}

}  // namespace credence::internal
