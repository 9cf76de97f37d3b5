#include "analysis/evidence/causes/lost_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/append_item.h"

namespace credence::internal {
namespace {

constexpr std::size_t kFewestToLose = 5, kMostOf = 4;
constexpr std::int64_t kFewestLostRows = 10;
constexpr double kBeyondMedian = 10.0, kOthersWrong = 2.0;

/// Of an even number of values the larger one in the middle.
double median_of_runs(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

LostRuns find_lost_runs(std::span<const RunCourse> runs) {
  if (runs.size() < kFewestToLose) return {};
  std::vector<double> means;
  means.reserve(runs.size());
  double rows = 0.0, sum = 0.0;
  const auto add = [&](const RunCourse& run, double sign) {
    rows += sign * static_cast<double>(run.rows);
    sum += sign * static_cast<double>(run.rows) * run.mean;
  };
  for (const RunCourse& run : runs) {
    means.push_back(run.mean);
    add(run, 1.0);
  }
  const double typical = median_of_runs(std::move(means));
  LostRuns found;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunCourse& run = runs[i];
    if (!(run.mean > kBeyondMedian * typical) || run.beyond < kFewestLostRows) continue;
    found.runs.push_back({static_cast<std::int64_t>(i), run.first, run.mean});
    add(run, -1.0);
  }
  if (found.runs.empty() || kMostOf * found.runs.size() > runs.size()) return {};
  found.others = static_cast<std::int64_t>(runs.size() - found.runs.size());
  found.factor_of_others = sum / rows;
  const bool wrong = !(found.factor_of_others < kOthersWrong && found.factor_of_others > 1.0 / kOthersWrong);
  return wrong ? LostRuns{} : found;
}

std::string name_of(const LostRun& run) {
  return run.name.empty() ? fmt::format("run {}", run.run) : run.name;
}

std::string names_of(const LostRuns& lost) {
  constexpr std::size_t kNamed = 5;
  const bool named = !lost.runs.front().name.empty();
  std::string names;
  for (std::size_t i = 0; i < std::min(kNamed, lost.runs.size()); ++i) {
    append_item(names, named ? lost.runs[i].name : std::to_string(lost.runs[i].run));
  }
  if (named) return names + (lost.runs.size() > kNamed ? ", …" : "");
  return fmt::format("run{} {}{} of {}", lost.runs.size() == 1 ? "" : "s", names,
                     lost.runs.size() > kNamed ? ", …" : "",
                     lost.others + static_cast<std::int64_t>(lost.runs.size()));
}

}  // namespace credence::internal
