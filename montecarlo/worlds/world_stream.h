#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/nan.h"
#include "core/types.h"
#include "montecarlo/scenario/scenario.h"

namespace credence::internal {

/// A step as a world tells it to a filter in any language; NaN where there is nothing.
struct StreamRow {
  Vector prior{};  ///< what the filter starts from; empty after step 0
  Vector truth{};
  Vector input{};        ///< empty at step 0
  Vector measurement{};  ///< empty where nothing is measured
};

/// Takes the steps of a run.
using RowVisitor = std::function<void(std::int64_t step, const StreamRow&)>;

/// The runs of a world without a filter: names of the numbers of each kind, and the rows.
struct WorldStream {
  std::vector<std::string> states, inputs{}, measurements;
  std::string notes{};  ///< what a filter must know beside the scenario, in lines
  /// All steps of a run, from 0 on, with the noise of the scenario's experiment. Where the rows come from the
  /// experiment itself, std::invalid_argument at the step at which its filter fails.
  std::function<void(std::int64_t run, const RowVisitor& take)> visit;
};

/// Of any scenario whose world tells what is measured. Throws std::invalid_argument for another, and as the
/// experiment of the scenario does.
WorldStream world_stream(const Scenario& scenario);

/// "landmark1.range", "landmark1.bearing", "landmark2.range", …
std::vector<std::string> names_of_landmarks(std::size_t count, const std::vector<std::string>& numbers);

/// "landmark1 = 3,4": where each of these points lies, in lines.
template <class Point>
std::string text_of_landmarks(const std::vector<Point>& points) {
  std::string text;
  for (std::size_t i = 0; i < points.size(); ++i) {
    text += fmt::format("landmark{} = {}\n", i + 1, fmt::join(points[i].begin(), points[i].end(), ","));
  }
  return text;
}

/// Each at the numbers of its landmark; empty where nothing is seen.
template <class Observation>
Vector numbers_of_observations(std::span<const Observation> seen, std::size_t landmarks) {
  if (seen.empty()) return {};
  const Index dim = seen.front().z.size();
  Vector z = Vector::Constant(dim * static_cast<Index>(landmarks), kNaN);
  for (const Observation& one : seen) z.segment(dim * Index{one.landmark}, dim) = one.z;
  return z;
}

}  // namespace credence::internal
