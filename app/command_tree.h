#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// @file
/// The commands and their options as data, from which help, completion and the man page are made.

namespace credence::internal {

/// An option, or a word that a command takes.
struct OptionShape {
  std::vector<std::string> names;    ///< "-h", "--help"; of a positional one its name
  std::string value;                 ///< "N", "text|json"; empty for a flag
  std::string about;                 ///< in words, with what is accepted and the default
  std::vector<std::string> choices;  ///< all accepted values, where they are few
  bool positional = false, required = false, repeatable = false;
};

struct CommandShape {
  std::string name, about, group, footer;
  std::vector<OptionShape> options;  ///< positional ones first
};

/// The command of this name, or null.
const CLI::App* find_command(const CLI::App& app, std::string_view name);

/// The options of a command and those of its groups, which CLI11 keeps as commands without a name but with a
/// --help of their own.
std::vector<const CLI::Option*> options_of(const CLI::App& command);

OptionShape shape_of(const CLI::Option& option);

/// "whole numbers from 0 to 4096": what an option with bounds takes.
std::string accepted_numbers(const CLI::Option& option);

/// All commands of the program, in the order in which they were added.
std::vector<CommandShape> command_shapes(const CLI::App& app);

/// Gives every command the look of our help, --version, and its group in the list.
void dress_commands(CLI::App& app);

}  // namespace credence::internal
