#pragma once

namespace CLI {
class App;
}

/// @file
/// Each command adds itself to the command line; its callback throws ExitStatus when it is done.

namespace credence {

/// How a command ended.
struct ExitStatus {
  int code = 0;
};

void add_run_command(CLI::App& app);
void add_sweep_command(CLI::App& app);
void add_merge_command(CLI::App& app);
void add_replay_command(CLI::App& app);
void add_stability_command(CLI::App& app);
void add_estimators_command(CLI::App& app);
void add_claims_command(CLI::App& app);
void add_check_command(CLI::App& app);
void add_plan_command(CLI::App& app);
void add_timing_command(CLI::App& app);
void add_selftest_command(CLI::App& app);

}  // namespace credence
