#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "app/commands.h"
#include "app/common_options.h"

namespace credence {
namespace {

/// What little is said stays in a buffer until now: only now one sees whether it could be written.
int after_output(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  fmt::print(stderr, "credence: the output could not be written\n");
  return kBadInput;
}

}  // namespace
}  // namespace credence

int main(int argc, char** argv) {
  using namespace credence;
  CLI::App app{"Credence tells whether a filter's covariance can be trusted.", "credence"};
  app.set_version_flag("--version", CREDENCE_VERSION);
  app.require_subcommand(1);
  app.footer("Examples:\n  credence run scenarios/figure1_two_landmarks.toml\n  credence run --help");
  add_run_command(app);
  add_sweep_command(app);
  add_merge_command(app);
  add_replay_command(app);
  add_stability_command(app);
  add_claims_command(app);
  add_check_command(app);
  add_plan_command(app);
  add_timing_command(app);
  add_selftest_command(app);
  try {
    app.parse(argc, argv);
  } catch (const ExitStatus& status) {
    return after_output(status.code);
  } catch (const CLI::ParseError& error) {
    return after_output(app.exit(error) == 0 ? kDone : kBadInput);
  } catch (const std::exception& error) {
    fmt::print(stderr, "credence: {}\n", error.what());
    return kBadInput;
  }
  return kDone;
}
