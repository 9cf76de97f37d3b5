#include "app/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/scenario_files.h"
#include "app/shell_word.h"
#include "core/names_in.h"
#include "montecarlo/scenario/scenario_schema.h"

namespace credence::internal {
namespace {

std::vector<std::string> setting_keys() {
  std::vector<std::string> keys;
  for (const ScenarioKey& key : scenario_keys()) keys.push_back(key.path() + "=");
  return keys;
}

bool takes_scenarios(const CommandShape& command) {
  return !command.options.empty() && command.options.front().positional &&
         command.options.front().names.front() == "scenario";
}

/// What is completed where a word of a command is expected, beside files.
std::vector<std::string> positional_words(const CommandShape& command) {
  if (takes_scenarios(command)) {
    const std::vector<std::string_view> names = names_in(own_scenarios());
    return {names.begin(), names.end()};
  }
  for (const OptionShape& option : command.options) {
    if (option.positional && !option.choices.empty()) return option.choices;
  }
  return {};
}

std::vector<std::string> option_names(const CommandShape& command) {
  std::vector<std::string> names;
  for (const OptionShape& option : command.options) {
    if (!option.positional) names.push_back(option.names.back());
  }
  return names;
}

/// Between single quotes within zsh's _arguments, where brackets and colons mean something.
std::string zsh_quoted(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return out;
}

/// Between single quotes of fish.
std::string fish_quoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

}  // namespace

std::string bash_completion(std::span<const CommandShape> commands) {
  std::string names, values, words;
  for (const CommandShape& command : commands) {
    names += command.name + " ";
    for (const OptionShape& option : command.options) {
      if (option.positional || option.choices.empty()) continue;
      values += fmt::format("    '{} {}') words={} ;;\n", command.name, option.names.back(),
                            in_quotes(fmt::format("{}", fmt::join(option.choices, " "))));
    }
    words += fmt::format("    {}) options={} words={} ;;\n", command.name,
                         in_quotes(fmt::format("{}", fmt::join(option_names(command), " "))),
                         in_quotes(fmt::format("{}", fmt::join(positional_words(command), " "))));
  }
  return fmt::format(R"(# Completion of credence in bash. source <(credence completion bash)
_credence() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} command= options= words= word
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    if [[ $word != -* ]]; then command=$word; break; fi
  done
  if [[ $before == --set ]]; then
    compopt -o nospace
    COMPREPLY=($(compgen -W {} -- "$current"))
    return
  fi
  case "$command" in
    '') options='--help --version' words={} ;;
{}  esac
  case "$command $before" in
{}  esac
  if [[ $current == -* ]]; then words=$options; fi
  COMPREPLY=($(compgen -W "$words" -- "$current"))
}}
complete -o default -F _credence credence
)",
                     in_quotes(fmt::format("{}", fmt::join(setting_keys(), " "))), in_quotes(names), words,
                     values);
}

std::string zsh_completion(std::span<const CommandShape> commands) {
  std::string names, cases;
  for (const CommandShape& command : commands) {
    names += fmt::format("    '{}:{}'\n", command.name, zsh_quoted(command.about));
    cases += fmt::format("    {})\n      choices=({})\n      _arguments \\\n", command.name,
                         fmt::join(positional_words(command), " "));
    for (const OptionShape& option : command.options) {
      if (option.positional) continue;
      std::string value;
      if (option.names.back() == "--set") {
        value = fmt::format(":setting:({})", fmt::join(setting_keys(), " "));
      } else if (!option.choices.empty()) {
        value = fmt::format(":value:({})", fmt::join(option.choices, " "));
      } else if (!option.value.empty()) {
        value = fmt::format(":{}:_files", zsh_quoted(option.value));
      }
      cases += fmt::format("        '{}{}[{}]{}' \\\n", option.repeatable ? "*" : "", option.names.back(),
                           zsh_quoted(option.about), value);
    }
    cases += "        '*:word:->words'\n      ;;\n";
  }
  return fmt::format(R"zsh(#compdef credence
# Completion of credence in zsh: a file _credence in a folder of $fpath.
_credence() {{
  local state
  local -a commands choices
  commands=(
{}  )
  if (( CURRENT == 2 )); then
    _describe command commands
    return
  fi
  shift words
  (( CURRENT-- ))
  case $words[1] in
{}  esac
  if [[ $state == words ]]; then
    _alternative "words:word:($choices)" 'files:file:_files'
  fi
}}
_credence "$@"
)zsh",
                     names, cases);
}

std::string fish_completion(std::span<const CommandShape> commands) {
  std::string text = "# Completion of credence in fish. credence completion fish | source\n";
  for (const CommandShape& command : commands) {
    text += fmt::format("complete -c credence -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                        fish_quoted(command.about));
    const std::string here =
        fmt::format("complete -c credence -n '__fish_seen_subcommand_from {}'", command.name);
    if (const std::vector<std::string> words = positional_words(command); !words.empty()) {
      text += fmt::format("{} -a {}\n", here, fish_quoted(fmt::format("{}", fmt::join(words, " "))));
    }
    for (const OptionShape& option : command.options) {
      if (option.positional) continue;
      std::string value = option.value.empty() ? "" : " -r";
      if (option.names.back() == "--set")
        value = " -x -a " + fish_quoted(fmt::format("{}", fmt::join(setting_keys(), " ")));
      if (!option.choices.empty())
        value = " -x -a " + fish_quoted(fmt::format("{}", fmt::join(option.choices, " ")));
      text += fmt::format("{} -l {}{} -d {}\n", here, option.names.back().substr(2), value,
                          fish_quoted(option.about));
    }
  }
  return text;
}

}  // namespace credence::internal
