#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "montecarlo/scenario/scenario.h"
#include "reports/figures/paper_style.h"

namespace CLI {
class App;
}  // namespace CLI

namespace credence::internal {

/// Exit codes of every command.
enum ExitCode : int { kDone = 0, kInconsistent = 1, kBadInput = 2, kSomeFailed = 3, kInterrupted = 130 };

/// Options that commands on a scenario share.
struct CommonOptions {
  std::vector<std::string> settings;  ///< --set section.key=value
  std::optional<std::int64_t> runs, steps, seed;
  int threads = 0;
  std::string out;
  std::vector<std::string> figures;  ///< words of paper_style
  std::string format = "text";
  bool quiet = false;
  bool fail_on_inconsistent = false;

  /// The settings with --runs, --steps and --seed as further overrides of [study].
  std::vector<std::string> overrides() const;
  /// --out, with --figures.
  ReportFolder report_folder() const;
};

/// Declares all common options on a command.
void add_common_options(CLI::App& command, CommonOptions& options);

/// Why nothing can be written into this folder, which may be made later; empty where it can be.
std::string writable_folder(const std::string& folder);

/// The same of a folder for a report, whose page is to replace nobody else's.
std::string folder_for_page(const std::string& folder);

/// The same of a file in a folder that is there.
std::string writable_file(const std::string& file);

/// Declares --figures, and refuses two widths when all is parsed.
void add_figures_option(CLI::App& command, CommonOptions& options);

/// Declares --out, --figures, --format and --quiet alone.
void add_output_options(CLI::App& command, CommonOptions& options);

/// Declares --format and --quiet, of a command that writes no report.
void add_print_options(CLI::App& command, CommonOptions& options,
                       const std::vector<std::string>& formats = {"text", "json", "latex"});

/// Declares --`key`, which takes the place of study.`key` and accepts what that does.
void add_study_option(CLI::App& command, std::string_view key, std::string_view about,
                      std::optional<std::int64_t>& value);

/// Declares --runs, --steps and --seed.
void add_study_options(CLI::App& command, CommonOptions& options);

/// Says that `command` makes all runs, where the scenario has a rule that would end them early.
void tell_of_stop_rule(const Scenario& scenario, std::string_view command);

/// Declares --set.
void add_setting_option(CLI::App& command, CommonOptions& options);

/// Declares --threads.
void add_threads_option(CLI::App& command, int& threads);

/// Declares --fail-on-inconsistent.
void add_fail_option(CLI::App& command, CommonOptions& options);

/// `Examples:` for the end of a command's help.
std::string examples(std::span<const char* const> lines);

/// The same of a command on a scenario, with where its keys are told.
std::string scenario_examples(std::span<const char* const> lines);

}  // namespace credence::internal
