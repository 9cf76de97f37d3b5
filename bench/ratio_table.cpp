#include "bench/ratio_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <ostream>

#include "analysis/studies/interleaved_timing.h"
#include "core/number_text.h"
#include "core/simd/cpu_dispatch.h"

namespace credence::internal {
namespace {

std::string full_name(std::string name) {
  static constexpr std::string_view kSet = "{set}";
  if (const auto at = name.find(kSet); at != std::string::npos) {
    name.replace(at, kSet.size(), instruction_set_name(best_instruction_set()));
  }
  return name;
}

/// The quantity in every repetition; nothing when the benchmark or its counter is missing.
std::optional<std::vector<double>> read(std::span<const BenchmarkTimes> times,
                                        const BenchmarkQuantity& quantity) {
  const std::string name = full_name(quantity.benchmark);
  const auto found = std::ranges::find(times, name, &BenchmarkTimes::name);
  if (found == times.end() || found->seconds.empty()) return std::nullopt;
  std::vector<double> values = found->seconds;
  if (quantity.per.empty()) return values;
  const auto count = std::ranges::find(found->counts, quantity.per, &std::pair<std::string, double>::first);
  if (count == found->counts.end() || !(count->second > 0.0)) return std::nullopt;
  for (double& value : values) value /= count->second;
  return values;
}

}  // namespace

int write_ratio_table(std::ostream& out, std::span<const BenchmarkTimes> times) {
  int missing = 0;
  out << "| work | time | against | its time | ratio | over the repetitions | goal | |\n"
         "|---|---|---|---|---|---|---|---|\n";
  for (const RatioGoal& goal : ratio_goals()) {
    const auto measured = read(times, goal.measured);
    auto reference = read(times, goal.reference);
    if (measured && goal.reference_seconds > 0.0) {
      reference = std::vector<double>(measured->size(), goal.reference_seconds);
    }
    if (!measured || !reference) {
      ++missing;
      continue;
    }
    const auto ratio = [&](double a, double b) { return goal.at_least ? b / a : a / b; };
    const double a = summarise_times(*measured).median, b = summarise_times(*reference).median,
                 middle = ratio(a, b);
    std::vector<double> all;
    for (std::size_t i = 0; i < std::min(measured->size(), reference->size()); ++i) {
      all.push_back(ratio((*measured)[i], (*reference)[i]));
    }
    const auto [low, high] = std::ranges::minmax(all);
    const bool met = goal.at_least ? middle >= goal.goal : middle <= goal.goal;
    out << fmt::format("| {} | {} | {} | {} | {:.3g} | {:.3g} … {:.3g} | {} {:g} | {} |\n", goal.work,
                       duration_text(a), goal.limit, duration_text(b), middle, low, high,
                       goal.at_least ? "≥" : "≤", goal.goal, met ? "met" : "MISSED");
  }
  return missing;
}

}  // namespace credence::internal
