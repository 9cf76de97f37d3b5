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
#include "app/tell_report.h"
#include "app/terminal_text.h"
#include "app/this_command.h"
#include "reports/document/selftest_report.h"

namespace credence {
namespace {

struct SelftestCommand : CommonOptions {
  SelftestOptions test;
};

void print_selftest(const SelftestCommand& command, const SelftestResult& result) {
  if (command.format == "json") {
    fmt::print("{}\n", selftest_json(result));
    return;
  }
  fmt::print("{}.\n\n", selftest_answer(result).text);
  for (const ReportTable& table : selftest_tables(result)) {
    fmt::print("{}\n", terminal_text(table));
  }
}

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
  print_selftest(command, result);
  if (!command.out.empty()) {
    write_selftest_report(command.report_folder(), result, make_provenance(this_command()));
    tell_report(command);
  }
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
  static constexpr const char* kExamples[] = {"credence selftest", "credence selftest --out out/selftest",
                                              "credence selftest --studies 20000 --seed 2 --format json"};
  command->footer("Exit code 3 when a test is out of calibration or a wrong filter is not found.\n\n" +
                  examples(kExamples));
  command->callback([options] { throw ExitStatus{selftest(*options)}; });
}

}  // namespace credence
