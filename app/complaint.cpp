#include "app/complaint.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>
#include <vector>

#include "app/command_tree.h"
#include "app/suggestion.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

constexpr std::string_view kOutOfRange = " not in range ";

/// The command that was called, or the program itself.
const CLI::App& called(const CLI::App& app) {
  const std::vector<CLI::App*> commands = app.get_subcommands();
  return commands.empty() ? app : *commands.front();
}

/// Of words that the command does not take: the first option among them, else the first.
std::string about_extras(const CLI::App& app, const CLI::App& command) {
  const std::vector<std::string> extras = app.remaining(true);
  const auto is_option = [](const std::string& word) { return word.starts_with('-'); };
  const auto option = std::ranges::find_if(extras, is_option);
  const std::string word = option != extras.end() ? *option : extras.empty() ? "" : extras.front();
  const bool comes_first = std::ranges::count(app.remaining(), word) > 0;
  if (comes_first && &command != &app &&
      command.get_option_no_throw(word.substr(0, word.find('='))) != nullptr)
    return fmt::format("{} stands before the command and belongs behind it", word);
  return fmt::format("{} is not expected{}", word, option_proposal(command, word));
}

/// Of "--runs = 1e4", which could not be converted.
std::string about_number(const CLI::App& command, const std::string& given) {
  const CLI::Option* const option = command.get_option_no_throw(given.substr(0, given.find(' ')));
  const bool whole = option != nullptr && shape_of(*option).value == "N";
  return fmt::format("{} is no {}number", given, whole ? "whole " : "");
}

/// Of "--runs: Value 0 not in range 1 to 5", where CLI11 writes all digits of the largest number.
std::string about_range(const CLI::App& command, const std::string& what) {
  constexpr std::string_view kValue = ": Value ";
  const std::string option = what.substr(0, what.find(kValue));
  const std::size_t begin = option.size() + kValue.size();
  const std::string value = what.substr(begin, what.rfind(kOutOfRange) - begin);
  if (value.empty()) return option + ": the value is missing";
  return fmt::format("{} {}: accepted are {}", option, value, accepted_numbers(*command.get_option(option)));
}

/// Of "--runs: 1 required INT missing" and "--runs: At Most 1 required but received 2".
std::string about_count(const std::string& what) {
  const std::string option = what.substr(0, what.find(':'));
  if (what.ends_with(" missing")) return option + ": the value is missing";
  return what.starts_with(option + ": At Most 1 ") ? option + ": is given more than once" : what;
}

}  // namespace

std::string complaint(const CLI::App& app, const CLI::ParseError& error) {
  constexpr std::string_view kConversion = "Could not convert: ";
  const CLI::App& command = called(app);
  std::string what = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
      (&command == &app && !app.remaining(true).empty())) {
    what = about_extras(app, command);
  } else if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    what = about_count(what);
  } else if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr && what.starts_with("--") &&
             what.find(kOutOfRange) != std::string::npos) {
    what = about_range(command, what);
  } else if (what.starts_with(kConversion)) {
    what = about_number(command, what.substr(kConversion.size()));
  }
  what = printable_line(what);
  if (&command == &app) return fmt::format("credence: {} (credence help)", what);
  return fmt::format("credence: {0}: {1} (credence help {0})", command.get_name(), what);
}

}  // namespace credence::internal
