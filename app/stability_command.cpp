#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "analysis/stability_analysis.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "montecarlo/filter_setup.h"
#include "montecarlo/scenario_help.h"
#include "montecarlo/scenario_io.h"
#include "reports/stability_report.h"
#include "reports/text_table.h"

namespace credence {
namespace {

struct StabilityOptions : CommonOptions {
  std::string scenario;
  Index horizon = 2000;
};

int stability(const StabilityOptions& options) {
  const Scenario scenario = load_scenario(options.scenario, options.overrides());
  if (scenario.world.model != WorldModel::monobot) {
    throw ScenarioError(fmt::format(
        "{}: world.model = \"{}\": stability handles linear worlds so far; accepted is \"monobot\"",
        options.scenario, to_string(scenario.world.model)));
  }
  const Index steps = scenario.study.steps;
  const StabilityAnalysis analysis = analyse_stability(
      make_assumed_model(scenario), make_inflation_rule(scenario), steps, std::max(options.horizon, steps));
  if (options.format == "json") {
    fmt::print("{}\n", stability_json(scenario, analysis));
  } else {
    const bool colour = isatty(STDOUT_FILENO) == 1;
    fmt::print("{}\n{}", text_table(stability_rank_table(analysis), colour),
               text_table(stability_verdict_table(analysis), colour));
  }
  if (!options.out.empty()) {
    for (const std::string& problem : write_stability_report(options.out, scenario, analysis)) {
      fmt::print(stderr, "credence: figure not drawn: {}\n", problem);
    }
    if (!options.quiet) {
      fmt::print(stderr, "Report: {}\n", (std::filesystem::path(options.out) / "index.html").string());
    }
  }
  return kDone;
}

}  // namespace

void add_stability_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "stability", "does P stay bounded? ranks, eigenvalues, Riccati equation, predicted and measured");
  auto options = std::make_shared<StabilityOptions>();
  command->add_option("scenario", options->scenario, "scenario file of a linear world")->required();
  add_common_options(*command, *options);
  command
      ->add_option("--horizon", options->horizon,
                   "steps of the long run; no fewer than those of the study are made")
      ->check(CLI::Range(Index{4}, Index{10'000'000}))
      ->capture_default_str();
  static constexpr const char* kExamples[] = {
      "credence stability scenarios/figure2_two_landmarks.toml",
      "credence stability scenarios/figure3_two_landmarks.toml --format json",
      "credence stability scenarios/figure3_two_landmarks.toml --set world.landmarks=6 --out out/stability"};
  command->footer(examples(kExamples) + "\n\n" + scenario_help());
  command->callback([options] { throw ExitStatus{stability(*options)}; });
}

}  // namespace credence
