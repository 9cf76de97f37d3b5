#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <stdexcept>

#include "app/command_tree.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/completion.h"
#include "app/suggestion.h"
#include "montecarlo/scenario/scenario_help.h"

namespace credence::internal {
namespace {

constexpr const char* kScenarioTopic = "scenario";

struct HelpOptions {
  std::string topic;
  bool man = false;
};

int help(const CLI::App& app, const HelpOptions& options) {
  if (options.man) {
    fmt::print("{}", man_page(command_shapes(app)));
  } else if (options.topic.empty()) {
    fmt::print("{}", app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal));
  } else if (options.topic == kScenarioTopic) {
    fmt::print("Keys of a scenario file, which --set section.key=value overrides:\n\n{}", scenario_help());
  } else {
    const CLI::App* const command = find_command(app, options.topic);
    if (command == nullptr) {
      throw std::invalid_argument(fmt::format("help: no command is called {}{}", options.topic,
                                              command_proposal(app, options.topic)));
    }
    fmt::print("{}", command->help(app.get_name()));
  }
  return kDone;
}

}  // namespace

void add_help_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("help", "help on a command, or on the keys of a scenario");
  auto options = std::make_shared<HelpOptions>();
  command->add_option("topic", options->topic, "a command, or \"scenario\" for all keys of a scenario file");
  command->add_flag("--man", options->man, "the manual page of all commands, for man");
  static constexpr const char* kExamples[] = {"credence help run", "credence help scenario",
                                              "credence help --man | man -l -"};
  command->footer(examples(kExamples));
  command->callback([options, &app] { throw ExitStatus{help(app, *options)}; });
}

void add_completion_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("completion", "what a shell needs to complete commands and options");
  auto shell = std::make_shared<std::string>();
  command->add_option("shell", *shell, "which shell")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  static constexpr const char* kExamples[] = {
      "source <(credence completion bash)",
      "mkdir -p ~/.zsh/completions && credence completion zsh > ~/.zsh/completions/_credence",
      ("mkdir -p ~/.config/fish/completions && credence completion fish > "
       "~/.config/fish/completions/credence.fish")};
  command->footer(examples(kExamples));
  command->callback([shell, &app] {
    const std::vector<CommandShape> commands = command_shapes(app);
    fmt::print("{}", *shell == "bash"  ? bash_completion(commands)
                     : *shell == "zsh" ? zsh_completion(commands)
                                       : fish_completion(commands));
    throw ExitStatus{kDone};
  });
}

}  // namespace credence::internal
