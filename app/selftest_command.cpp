#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "analysis/studies/selftest.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/launched_ranks.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/tell.h"
#include "reports/document/checks/selftest_report.h"

namespace credence::internal {
namespace {

struct SelftestCommand : CommonOptions {
  SelftestOptions test;
};

int selftest(SelftestCommand& command) {
  ProgressDisplay display("selftest", command.quiet, "studies");
  command.test.stop = &catch_interrupt();
  command.test.ranks = launched_ranks();
  command.test.progress = [&](std::int64_t done, std::int64_t total) {
    display.show({.runs_done = done, .runs_stored = 0, .runs_total = total});
  };
  const SelftestResult result = run_selftest(command.test);
  if (!result.complete) {
    say("credence: selftest interrupted, nothing is proved");
    return kInterrupted;
  }
  tell(selftest_document(result), command);
  for (const std::string& failure : selftest_failures(result)) {
    say(fmt::format("credence: SELFTEST FAILED: {}", failure));
  }
  return result.ok ? kDone : kSomeFailed;
}

}  // namespace

void add_selftest_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("selftest", "calibration of the tests themselves: false-alarm rate and power");
  auto options = std::make_shared<SelftestCommand>();
  command->add_option("--studies", options->test.studies, "studies for each false-alarm rate")
      ->check(CLI::Range(100, 100'000'000))
      ->capture_default_str();
  command->add_option("--seed", options->test.seed, "seed of all studies")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  add_threads_option(*command, options->test.threads);
  add_output_options(*command, *options);
  static constexpr const char* kExamples[] = {"credence selftest    # two minutes of one core",
                                              "credence selftest --out out/selftest",
                                              "credence selftest --studies 20000 --seed 2 --format json"};
  command->footer("Exit code 3 when a test is out of calibration or a wrong filter is not found.\n\n" +
                  examples(kExamples));
  command->callback([options] { throw ExitStatus{selftest(*options)}; });
}

}  // namespace credence::internal
