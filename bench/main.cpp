// All benchmarks in one program, so that every ratio is of two times of one run. Flags are those of Google
// Benchmark; by default nine repetitions in random order. Behind its output stands the table of ratios.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "bench/ratio_table.h"
#include "core/simd/cpu_dispatch.h"

namespace {

using credence::internal::BenchmarkTimes;

/// Shows what a ConsoleReporter shows, and keeps the times of every repetition.
class CollectingReporter final : public benchmark::ConsoleReporter {
 public:
  CollectingReporter() : ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
      keep(run);
    }
  }

  const std::vector<BenchmarkTimes>& times() const { return times_; }

 private:
  void keep(const Run& run) {
    // The repetitions of a benchmark have one name.
    benchmark::BenchmarkName name = run.run_name;
    name.repetitions.clear();
    const bool real = !name.time_type.empty();
    const std::string full = name.str();
    const double iterations = static_cast<double>(run.iterations);
    const double seconds = (real ? run.real_accumulated_time : run.cpu_accumulated_time) / iterations;
    auto found = std::ranges::find(times_, full, &BenchmarkTimes::name);
    if (found == times_.end()) found = times_.insert(found, BenchmarkTimes{full, {}, {}});
    found->seconds.push_back(seconds);
    found->counts.clear();
    for (const auto& [counter, value] : run.counters) {
      const bool items = counter == "items_per_second";
      found->counts.emplace_back(items ? "items" : counter, items ? value.value * seconds : value.value);
    }
  }

  std::vector<BenchmarkTimes> times_;
};

/// Medians and scatter alone: what is worth keeping.
class MedianJsonReporter final : public benchmark::JSONReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    std::vector<Run> kept;
    std::ranges::copy_if(runs, std::back_inserter(kept), [](const Run& run) {
      return run.error_occurred || run.aggregate_name == "median" || run.aggregate_name == "cv";
    });
    if (!kept.empty()) JSONReporter::ReportRuns(kept);
  }
};

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> defaults = {"--benchmark_repetitions=9",
                                       "--benchmark_enable_random_interleaving=true",
                                       "--benchmark_min_time=0.05"};
  // What the user says comes later and wins.
  std::vector<char*> arguments{argv[0]};
  for (std::string& flag : defaults) arguments.push_back(flag.data());
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::AddCustomContext("instruction_set", credence::internal::instruction_set_name(
                                                     credence::internal::best_instruction_set()));
  CollectingReporter reporter;
  MedianJsonReporter json;
  // Google Benchmark asks for a file to write to when it is given a reporter for it.
  const bool to_file = std::any_of(argv, argv + argc, [](const char* argument) {
    return std::string_view(argument).starts_with("--benchmark_out=");
  });
  benchmark::RunSpecifiedBenchmarks(&reporter, to_file ? &json : nullptr);
  std::cout << '\n';
  const int missing = credence::internal::write_ratio_table(std::cout, reporter.times());
  if (missing > 0) std::cout << fmt::format("\n{} goals left out: their benchmarks were not run.\n", missing);
}
