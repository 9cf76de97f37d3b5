#include "analysis/evidence/causes/lost_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "analysis/laws/chi_square/chi_square.h"
#include "core/append_item.h"

namespace credence::internal {
namespace {

constexpr double kLostLevel = 1e-3;
constexpr std::size_t kFewestToLose = 5, kMostOf = 4;
constexpr std::int64_t kFewestLostRows = 10;
constexpr double kBeyondMedian = 10.0, kOthersWrong = 2.0;

double sum_of_run(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum;
}

/// Of an even number of values the larger one in the middle.
double median_of_runs(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

LostRuns find_lost_runs(std::span<const std::vector<double>> nees, double least_dof) {
  if (nees.size() < kFewestToLose || !(least_dof > 0.0)) return {};
  std::vector<double> means;
  double rows = 0.0, sum = 0.0;
  for (const std::vector<double>& run : nees) {
    if (run.empty()) return {};
    means.push_back(sum_of_run(run) / static_cast<double>(run.size()));
    rows += static_cast<double>(run.size());
    sum += sum_of_run(run);
  }
  const double limit = chi_square_upper_quantile(kLostLevel / rows, least_dof) / least_dof;
  const double typical = median_of_runs(means);
  LostRuns found;
  for (std::size_t i = 0; i < nees.size(); ++i) {
    if (!(means[i] > kBeyondMedian * typical)) continue;
    const auto beyond = [limit](double value) { return value > limit; };
    if (std::ranges::count_if(nees[i], beyond) < kFewestLostRows) continue;
    const auto first = std::ranges::find_if(nees[i], beyond);
    found.runs.push_back({static_cast<std::int64_t>(i), first - nees[i].begin() + 1, means[i]});
    rows -= static_cast<double>(nees[i].size());
    sum -= sum_of_run(nees[i]);
  }
  if (found.runs.empty() || kMostOf * found.runs.size() > nees.size()) return {};
  found.others = static_cast<std::int64_t>(nees.size() - found.runs.size());
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
