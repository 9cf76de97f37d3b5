#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <sstream>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/say.h"

namespace credence {
namespace {

/// A standard stream that was closed would give its number to the next file that is opened, and what is said
/// would be written into that.
void occupy_standard_streams() {
  while (true) {
    const int descriptor = open("/dev/null", O_RDONLY);  // so that writing fails as it did when closed
    if (descriptor <= STDERR_FILENO && descriptor >= 0) continue;
    close(descriptor);
    return;
  }
}

/// What little is said stays in a buffer until now: only now one sees whether it could be written.
int after_output(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  say("credence: the output could not be written");
  return kBadInput;
}

/// Prints help or the version, or says what is wrong with the arguments.
int after_parsing(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream message;
  const int code = app.exit(error, std::cout, message);
  if (code == 0) return after_output(kDone);
  std::string text = message.str();
  if (text.ends_with('\n')) text.pop_back();
  say(text);
  return kBadInput;
}

}  // namespace
}  // namespace credence

int main(int argc, char** argv) {
  using namespace credence;
  occupy_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a limit of the size of files is then an error of the write
  CLI::App app{"Credence tells whether a filter's covariance can be trusted.", "credence"};
  app.set_version_flag("--version", CREDENCE_VERSION);
  app.require_subcommand(1);
  app.footer("Examples:\n  credence run scenarios/figure1_two_landmarks.toml\n  credence run --help");
  add_run_command(app);
  add_sweep_command(app);
  add_merge_command(app);
  add_replay_command(app);
  add_stability_command(app);
  add_estimators_command(app);
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
    return after_parsing(app, error);
  } catch (const std::bad_alloc&) {
    say("credence: there is not enough memory for this; fewer landmarks, steps or points of a sweep need "
        "less");
    return kBadInput;
  } catch (const std::exception& error) {
    say(fmt::format("credence: {}", error.what()));
    return kBadInput;
  }
  return kDone;
}
