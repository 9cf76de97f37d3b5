#include "app/common_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <system_error>
#include <variant>

#include "app/say.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "reports/document/report_index.h"

namespace credence::internal {

std::vector<std::string> CommonOptions::overrides() const {
  std::vector<std::string> all = settings;
  if (runs) all.push_back(fmt::format("study.runs={}", *runs));
  if (steps) all.push_back(fmt::format("study.steps={}", *steps));
  if (seed) all.push_back(fmt::format("study.seed={}", *seed));
  return all;
}

void tell_of_stop_rule(const Scenario& scenario, std::string_view command) {
  if (scenario.stop == StopSettings()) return;
  say(fmt::format("{}: {} leaves [study.stop] aside, which is of run and sweep", scenario.name, command));
}

ReportFolder CommonOptions::report_folder() const { return {out, paper_style(figures)}; }

void add_figures_option(CLI::App& command, CommonOptions& options) {
  command
      .add_option(
          "--figures", options.figures,
          fmt::format(
              "what its figures are written as, of {}; default: svg,pdf, as wide as their panels need",
              fmt::join(paper_words(), ", ")))
      ->type_name("LIST")
      ->delimiter(',');
  command.parse_complete_callback([&options] {
    try {
      paper_style(options.figures);
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError("--figures", error.what());
    }
  });
}

std::string writable_folder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::path there = fs::path(folder).lexically_normal();
  while (!there.empty() && !fs::exists(there, error) && !error) there = there.parent_path();
  if (there.empty()) there = ".";
  if (error) return fmt::format("{}: {}", folder, error.message());
  if (!fs::is_directory(there, error)) {
    return there == folder ? folder + " is no folder"
                           : fmt::format("{} cannot be made: {} is no folder", folder, there.string());
  }
  if (access(there.c_str(), W_OK) == 0) return {};
  return fmt::format("nothing can be written into {} ({})", there.string(),
                     std::generic_category().message(errno));
}

std::string folder_for_page(const std::string& folder) {
  const std::filesystem::path page = std::filesystem::path(folder) / "index.html";
  if (is_page_of_others(page)) {
    return fmt::format(
        "{}: is there already and no page of a report: name another folder, or move the file away",
        page.string());
  }
  return writable_folder(folder);
}

std::string writable_file(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::is_directory(file, error)) return file + " is a folder";
  const fs::path folder = fs::path(file).parent_path();
  if (!folder.empty() && !fs::exists(folder, error))
    return fmt::format("there is no folder {}", folder.string());
  return writable_folder(folder.string());
}

void add_output_options(CLI::App& command, CommonOptions& options) {
  CLI::Option* const out = command.add_option("--out", options.out, "folder for the report and its figures")
                               ->type_name("DIR")
                               ->check(folder_for_page);
  add_figures_option(command, options);
  command.get_option("--figures")->needs(out);
  add_print_options(command, options);
}

void add_print_options(CLI::App& command, CommonOptions& options, const std::vector<std::string>& formats) {
  command.add_option("--format", options.format, "what is printed on stdout")
      ->check(CLI::IsMember(formats))
      ->capture_default_str();
  command.add_flag("--quiet", options.quiet, "no progress on stderr");
}

void add_study_option(CLI::App& command, std::string_view key, std::string_view about,
                      std::optional<std::int64_t>& value) {
  const auto& field = std::get<IntegerField>(find_scenario_key("study", key)->field);
  command.add_option(fmt::format("--{}", key), value, fmt::format("{}, instead of study.{}", about, key))
      ->check(CLI::Range(field.low, field.high));
}

void add_study_options(CLI::App& command, CommonOptions& options) {
  add_study_option(command, "runs", "number of Monte Carlo runs", options.runs);
  add_study_option(command, "steps", "steps of each run", options.steps);
  add_study_option(command, "seed", "seed", options.seed);
}

void add_setting_option(CLI::App& command, CommonOptions& options) {
  command.add_option("--set", options.settings, "override a setting: section.key=value (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

void add_threads_option(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "worker threads; 0: one for each processor")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
}

void add_fail_option(CLI::App& command, CommonOptions& options) {
  command.add_flag("--fail-on-inconsistent", options.fail_on_inconsistent,
                   "exit with 1 when a verdict is optimistic, pessimistic or mixed; undecided is no failure");
}

void add_common_options(CLI::App& command, CommonOptions& options) {
  add_setting_option(command, options);
  add_study_options(command, options);
  add_threads_option(command, options.threads);
  add_fail_option(command, options);
  add_output_options(command, options);
}

std::string examples(std::span<const char* const> lines) {
  std::string text = "Examples:";
  for (const char* line : lines) text += fmt::format("\n  {}", line);
  return text;
}

std::string scenario_examples(std::span<const char* const> lines) {
  return examples(lines) + "\n\nAll keys of a scenario, for the file and for --set: credence help scenario";
}

}  // namespace credence::internal
