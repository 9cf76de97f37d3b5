#include "analysis/evidence/causes/lost_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "analysis/evidence/sums/evidence.h"
#include "analysis/laws/mean/student.h"
#include "core/append_item.h"
#include "montecarlo/engine/moments.h"

namespace credence::internal {
namespace {

constexpr std::size_t kFewestToLose = 5, kMostOf = 4;
constexpr std::int64_t kFewestLostRows = 10, kFewestOfFailed = 3;
constexpr double kBeyondMedian = 10.0, kOthersWrong = 2.0;

/// Of an even number of values the larger one in the middle.
double median_of_runs(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

LostRuns find_lost_runs(std::span<const CourseOfRun> runs) {
  if (runs.size() < kFewestToLose) return {};
  std::vector<double> means;
  means.reserve(runs.size());
  for (const CourseOfRun& run : runs) means.push_back(run.course.mean);
  const double typical = median_of_runs(std::move(means));
  LostRuns found;
  Moments others;
  double rows = 0.0, sum = 0.0;  // of these
  for (const auto& [number, failed_at, run] : runs) {
    found.last = std::max(found.last, number);
    const std::int64_t fewest = failed_at > 0 ? kFewestOfFailed : kFewestLostRows;
    if (!(run.mean > kBeyondMedian * typical) || run.beyond < fewest) {
      others.add(run.mean);
      rows += static_cast<double>(run.rows);
      sum += static_cast<double>(run.rows) * run.mean;
      continue;
    }
    found.runs.push_back(
        {.run = number, .row = run.first, .factor = run.mean, .name = {}, .failed_at = failed_at});
  }
  if (found.runs.empty() || kMostOf * found.runs.size() > runs.size()) return {};
  found.others = static_cast<std::int64_t>(runs.size() - found.runs.size());
  found.factor_of_others = sum / rows;
  const auto count = static_cast<double>(others.count);
  const double t = (others.mean - 1.0) / std::sqrt(others.variance() / count);
  found.p_value_of_others = student_two_sided_p_value(t, count - 1.0);
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
  return fmt::format("run{} {}{} (of 0 to {})", lost.runs.size() == 1 ? "" : "s", names,
                     lost.runs.size() > kNamed ? ", …" : "", lost.last);
}

bool rows_are_steps(const RunSums& runs, const ConsistencyVerdict& nees) {
  const auto steps = std::ssize(nees.steps);
  const auto of_all = [steps](const std::vector<double>& run) { return std::ssize(run) == steps; };
  return nees.step_stride == 1 && std::ranges::all_of(runs.nees, of_all) &&
         std::ranges::all_of(runs.further, [steps](const RunCourse& run) { return run.rows == steps; }) &&
         std::ranges::all_of(runs.failed,
                             [](const CourseOfRun& run) { return run.course.rows + 1 == run.failed_at; });
}

std::string place_of(const LostRun& run, bool by_step, const ConsistencyVerdict& nees) {
  return by_step ? nees.text_of_step(run.row) : fmt::format("its row {}", run.row);
}

}  // namespace credence::internal
