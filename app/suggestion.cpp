#include "app/suggestion.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <vector>

#include "app/command_tree.h"
#include "core/names_in.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/scenario/scenario_value.h"

namespace credence::internal {
namespace {

/// "--set world.landmarks=…" for "--landmarks", where the command takes --set.
std::string setting_proposal(const CLI::App& command, std::string_view option) {
  if (command.get_option_no_throw("--set") == nullptr) return {};
  std::string name(option.substr(std::min(option.find_first_not_of('-'), option.size())));
  std::ranges::replace(name, '-', '_');
  for (const ScenarioKey& key : scenario_keys()) {
    if (key.name == name || key.path() == name)
      return fmt::format("; did you mean --set {}=VALUE?", key.path());
  }
  return {};
}

}  // namespace

std::string command_proposal(const CLI::App& app, std::string_view word) {
  const std::vector<CommandShape> commands = command_shapes(app);
  const std::string_view close = closest_word(word, names_in(commands));
  return close.empty() ? "; credence help lists all" : fmt::format("; did you mean {}?", close);
}

std::string option_proposal(const CLI::App& command, std::string_view option) {
  if (option == "--json" && command.get_option_no_throw("--format") != nullptr)
    return "; did you mean --format json?";
  if (std::string setting = setting_proposal(command, option); !setting.empty()) return setting;
  std::vector<std::string> names;
  for (const CLI::Option* known : options_of(command)) {
    for (const std::string& name : known->get_lnames()) names.push_back("--" + name);
  }
  const std::string_view close = closest_word(option, {names.begin(), names.end()});
  return close.empty() ? "" : fmt::format("; did you mean {}?", close);
}

}  // namespace credence::internal
