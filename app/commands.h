#pragma once

namespace CLI {
class App;
}

/// @file
/// Each command adds itself to the command line; its callback throws ExitStatus when it is done.

namespace credence::internal {

/// How a command ended.
struct ExitStatus {
  int code = 0;
  bool resumes = false;  ///< the same command would go on where this one was interrupted
};

void add_run_command(CLI::App& app);
void add_sweep_command(CLI::App& app);
void add_merge_command(CLI::App& app);
void add_submit_command(CLI::App& app);
void add_replay_command(CLI::App& app);
void add_stability_command(CLI::App& app);
void add_estimators_command(CLI::App& app);
void add_claims_command(CLI::App& app);
void add_check_command(CLI::App& app);
void add_plan_command(CLI::App& app);
void add_tune_command(CLI::App& app);
void add_timing_command(CLI::App& app);
void add_selftest_command(CLI::App& app);
void add_world_command(CLI::App& app);
void add_show_command(CLI::App& app);
void add_compare_command(CLI::App& app);
void add_report_command(CLI::App& app);
void add_init_command(CLI::App& app);
void add_explain_command(CLI::App& app);
void add_index_command(CLI::App& app);
void add_list_command(CLI::App& app);
void add_schema_command(CLI::App& app);
void add_help_command(CLI::App& app);
void add_completion_command(CLI::App& app);

}  // namespace credence::internal
