#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "analysis/studies/filter_timing.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/tell.h"
#include "reports/document/checks/timing_report.h"

namespace credence::internal {
namespace {

struct TimingCommand : CommonOptions {
  FilterTimingPlan plan;
};

int timing(TimingCommand& command) {
  ProgressDisplay display("timing", command.quiet, "timings");
  const std::atomic<bool>& stop = catch_interrupt();
  const TimingResult result = time_filters(command.plan, &stop, [&](std::int64_t done, std::int64_t total) {
    display.show({.runs_done = done, .runs_stored = 0, .runs_total = total});
  });
  if (result.filters.empty()) {
    say("credence: timing interrupted before its first round");
    return kInterrupted;
  }
  tell(timing_document(result), command);
  return result.complete ? kDone : kInterrupted;
}

}  // namespace

void add_timing_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "timing", "time per step against the size of the map, O(N) and O(N^2); speed of Monte Carlo");
  auto options = std::make_shared<TimingCommand>();
  command
      ->add_option(
          "--landmarks", options->plan.landmarks,
          fmt::format("sizes of the map, comma-separated; the full filter up to {}, the textbook one "
                      "up to {}",
                      largest_map(TimedFilter::full), largest_map(TimedFilter::naive)))
      ->delimiter(',')
      ->check(CLI::Range(Index{1}, largest_map(TimedFilter::map)))
      ->capture_default_str();
  command->add_option("--observed", options->plan.observed, "landmarks seen in a step, comma-separated")
      ->delimiter(',')
      ->check(CLI::Range(Index{1}, Index{1000}))
      ->capture_default_str();
  command->add_option("--repetitions", options->plan.timing.repetitions, "of which the median is taken")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  add_output_options(*command, *options);
  static constexpr const char* kExamples[] = {
      "credence timing", "credence timing --out out/timing",
      "credence timing --landmarks 10,100,1000 --observed 1 --format json"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{timing(*options)}; });
}

}  // namespace credence::internal
