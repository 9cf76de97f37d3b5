#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <vector>

namespace credence::internal {

/// What is read off one benchmark: its time, or its time divided by one of its counters.
struct BenchmarkQuantity {
  std::string benchmark;  ///< its full name; "{set}" stands for the widest instruction set of the machine
  std::string per{};      ///< "": seconds per iteration; "items": per item; else per one of a user counter
};

/// A goal: the ratio of two times measured in one run, or of one to a time that is given.
struct RatioGoal {
  std::string work;   ///< what is measured
  std::string limit;  ///< what it is measured against
  BenchmarkQuantity measured, reference{};
  double reference_seconds = 0.0;  ///< > 0: takes the place of `reference`
  double goal = 1.0;
  bool at_least =
      false;  ///< reference / measured >= goal (so many times faster), else measured / reference <= goal
};

/// The goals that performance is held to, in the order of the table.
std::span<const RatioGoal> ratio_goals();

/// The seconds of all repetitions of a benchmark.
struct BenchmarkTimes {
  std::string name;
  std::vector<double> seconds;                         ///< of one iteration, one value a repetition
  std::vector<std::pair<std::string, double>> counts;  ///< how many in one iteration: items and counters
};

/// Writes a Markdown table of the goals whose two benchmarks were run: medians, their ratio, its smallest and
/// largest over the repetitions, the goal. Returns how many goals were left out because a name is missing.
int write_ratio_table(std::ostream& out, std::span<const BenchmarkTimes> times);

}  // namespace credence::internal
