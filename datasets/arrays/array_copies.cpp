#include "datasets/arrays/array_copies.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace credence::internal {

CopiedRuns array_copies(const ArrayRuns& arrays) {
  constexpr std::size_t kMost = 4096;
  RoundedCopies copies;
  const std::size_t states = arrays.layout.states.size();
  for (std::size_t r = 0; r < std::min(kMost, arrays.runs.size()); ++r) {
    const ArrayRun& run = arrays.runs[r];
    copies.begin_run();
    const bool of_error = run.error.data != nullptr;
    if (!of_error && run.innovations.empty()) continue;
    const ArrayRows& rows = of_error ? run.error : run.innovations.front().nu;
    const std::size_t width = of_error ? states : static_cast<std::size_t>(arrays.layout.sensors.front().dim);
    if (rows.data == nullptr) continue;
    for (std::int64_t row = 0; row < run.steps; ++row) copies.add_row(std::span(rows.at(row), width));
  }
  return copies.found(
      [&](std::size_t r) { return fmt::format("run {}", arrays.first_run + static_cast<std::int64_t>(r)); });
}

}  // namespace credence::internal
