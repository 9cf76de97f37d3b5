#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <set>
#include <span>
#include <sstream>
#include <string>

#include "app/command_tree.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/complaint.h"
#include "app/launched_ranks.h"
#include "app/say.h"
#include "app/shell_word.h"
#include "app/suggestion.h"
#include "core/append_item.h"
#include "core/large_pages.h"
#include "core/stop_point.h"
#include "core/version.h"
#include "montecarlo/engine/shared_tasks.h"

namespace credence::internal {
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
  if (app.exit(error, std::cout, message) == 0) return after_output(kDone);
  say(complaint(app, error));
  return kBadInput;
}

/// Says what is wrong; a helper says it to rank 0.
int after_failure(const std::string& why) {
  if (Ranks* ranks = launched_ranks(); is_helper(ranks)) report_failure(*ranks, why);
  say("credence: " + why);
  return kBadInput;
}

/// After an interruption: how to go on.
void tell_how_to_continue(std::span<char*> arguments) {
  std::string command;
  for (const std::string word : arguments) {
    if (word == "--fresh") continue;  // which would begin anew
    append_item(command, shell_word(word), " ");
  }
  say("Interrupted; what is done is stored. This goes on with it:\n  " + command);
}

/// In the order of the list of commands.
void add_commands(CLI::App& app) {
  app.require_subcommand(1);
  app.footer("Examples:\n  credence run planar_loop\n  credence check my_filter.csv\n  credence help run");
  add_run_command(app);
  add_sweep_command(app);
  add_estimators_command(app);
  add_tune_command(app);
  add_check_command(app);
  add_world_command(app);
  add_replay_command(app);
  add_show_command(app);
  add_compare_command(app);
  add_report_command(app);
  add_merge_command(app);
  add_submit_command(app);
  add_stability_command(app);
  add_plan_command(app);
  add_claims_command(app);
  add_timing_command(app);
  add_selftest_command(app);
  add_init_command(app);
  add_explain_command(app);
  add_index_command(app);
  add_list_command(app);
  add_schema_command(app);
  add_completion_command(app);
  add_help_command(app);
  dress_commands(app);
}

/// What all ranks work on together; of the others rank 0 does everything.
bool is_shared(const std::string& command) {
  static const std::set<std::string> kShared{"run", "sweep", "selftest", "estimators"};
  return kShared.contains(command);
}

int obey(int argc, char** argv) {
  CLI::App app{"Credence tells whether a filter's covariance can be trusted.", "credence"};
  add_commands(app);
  if (argc < 2) {
    fmt::print("{}", app.help());
    return after_output(kBadInput);
  }
  const std::string first = argv[1];
  if (is_helper(launched_ranks()) && !is_shared(first)) return kDone;
  if (first == "version") {
    fmt::print("{}\n", version_text());
    return after_output(kDone);
  }
  if (!first.starts_with('-') && find_command(app, first) == nullptr) {
    say(fmt::format("credence: no command is called {}{}", first, command_proposal(app, first)));
    return kBadInput;
  }
  try {
    app.parse(argc, argv);
  } catch (const ExitStatus& status) {
    const int code = after_output(status.code);
    if (code == kInterrupted && status.resumes) tell_how_to_continue({argv, static_cast<std::size_t>(argc)});
    return code;
  } catch (const CLI::ParseError& error) {
    return after_parsing(app, error);
  } catch (const RanksEnded&) {
    return kDone;
  } catch (const Stopped&) {
    say(fmt::format("credence: {} interrupted; nothing is kept of what is not done", first));
    return kInterrupted;
  } catch (const std::bad_alloc&) {
    return after_failure(
        "there is not enough memory for this; fewer landmarks, steps or points of a sweep need less");
  } catch (const std::filesystem::filesystem_error& error) {
    return after_failure(fmt::format("{}: {}", error.path1().string(), error.code().message()));
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return after_output(kBadInput);
    return after_failure(error.what());
  }
  return kDone;
}

}  // namespace
}  // namespace credence::internal

int main(int argc, char** argv) {
  using namespace credence::internal;
  use_large_pages();
  occupy_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a limit of the size of files is then an error of the write
  try {
    const bool helps = is_helper(launched_ranks());
    const int code = obey(argc, argv);
    leave_ranks();
    return helps ? kDone : code;  // what went wrong is told by rank 0, and by its code
  } catch (const std::exception& error) {
    say(fmt::format("credence: {}", error.what()));
    return kBadInput;
  }
}
