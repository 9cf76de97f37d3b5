#include "app/command_tree.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <unistd.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string_view>
#include <system_error>

#include "app/terminal_text.h"
#include "core/version.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

constexpr std::size_t kOptionColumn = 26, kWidestHelp = 100;

/// "INT in [0 - 4096]" as "from 0 to 4096"; what else a validator says is in the words already.
std::string range_text(std::string_view validators) {
  if (validators == "POSITIVE") return "above 0";
  if (validators == "NONNEGATIVE") return "from 0 on";
  const std::size_t open = validators.find("in ["), middle = validators.find(" - "),
                    close = validators.find(']');
  if (open == std::string_view::npos || middle == std::string_view::npos || close == std::string_view::npos)
    return {};
  return fmt::format("from {} to {}", validators.substr(open + 4, middle - open - 4),
                     validators.substr(middle + 3, close - middle - 3));
}

/// "{text,json}" as words.
std::vector<std::string> words_of(std::string_view validators) {
  if (!validators.starts_with('{') || !validators.ends_with('}')) return {};
  return CLI::detail::split(std::string(validators.substr(1, validators.size() - 2)), ',');
}

/// CLI11's name of a type, as people write it.
std::string value_name(const std::string& type) {
  static const std::map<std::string, std::string, std::less<>> kNames = {
      {"INT", "N"}, {"UINT", "N"}, {"FLOAT", "X"}, {"TEXT", "TEXT"}};
  const auto found = kNames.find(type);
  return found == kNames.end() ? type : found->second;
}

/// The heading under which a command stands in the list.
std::string group_of(const std::string& command) {
  static const std::map<std::string, std::string, std::less<>> kGroups = {
      {"run", "Simulate and judge"},
      {"sweep", "Simulate and judge"},
      {"estimators", "Simulate and judge"},
      {"tune", "Simulate and judge"},
      {"check", "Judge what others wrote"},
      {"replay", "Judge what others wrote"},
      {"world", "Judge what others wrote"},
      {"show", "Look at results"},
      {"compare", "Look at results"},
      {"report", "Look at results"},
      {"merge", "Look at results"},
      {"submit", "Simulate and judge"},
      {"index", "Look at results"},
      {"init", "Begin"},
      {"list", "Begin"},
      {"schema", "Begin"},
      {"help", "Begin"},
      {"explain", "Begin"},
      {"completion", "Begin"}};
  const auto found = kGroups.find(command);
  return found == kGroups.end() ? "Theory and calibration" : found->second;
}

std::size_t help_width() {
  const std::size_t columns = terminal_width(STDOUT_FILENO);
  return columns == 0 ? kWidestHelp : std::clamp<std::size_t>(columns, 40, kWidestHelp);
}

/// A name and what it is, the second beginning in one column and broken between words.
std::string entry(const std::string& name, std::string_view about) {
  const std::string indent(kOptionColumn, ' ');
  std::string text = "  " + name;
  text += text.size() + 2 > kOptionColumn ? "\n" + indent : indent.substr(text.size());
  return fmt::format("{}{}\n", text,
                     fmt::join(wrapped_lines(about, help_width() - kOptionColumn), "\n" + indent));
}

/// What CLI11 would take for another value: "", as of a variable that is not set, for none, 010 for eight, a
/// whole number that is too large for the largest, and NaN as within every range.
std::string problem_of_value(const std::string& kind, const std::string& text) {
  if (text.empty()) return "the value is missing";
  if (kind == "X" && std::isnan(std::strtod(text.c_str(), nullptr))) return text + " is no number";
  if (kind != "N") return {};
  const std::string_view digits = std::string_view(text).substr(text.starts_with('-') ? 1 : 0);
  if (digits.size() > 1 && digits.starts_with('0')) {
    return text + " begins with 0; numbers are written in decimal";
  }
  std::int64_t ignored = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), ignored);
  return read.ec == std::errc::result_out_of_range ? text + " is too large" : std::string();
}

/// Our help: what a value is in words, not in CLI11's signs.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() {
    label("OPTIONS", "OPTIONS");
    label("SUBCOMMAND", "COMMAND");
    column_width(kOptionColumn);
  }

  std::string make_option(const CLI::Option* option, bool positional) const override {
    const OptionShape shape = shape_of(*option);
    std::string name = fmt::format("{}", fmt::join(shape.names, ", "));
    if (!positional && !shape.value.empty()) name += " " + shape.value;
    return entry(name, shape.about);
  }

  std::string make_subcommand(const CLI::App* command) const override {
    return entry(command->get_name(), command->get_description());
  }
};

}  // namespace

const CLI::App* find_command(const CLI::App& app, std::string_view name) {
  const auto found =
      app.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

std::vector<const CLI::Option*> options_of(const CLI::App& command) {
  std::vector<const CLI::Option*> options = command.get_options();
  for (const CLI::App* group :
       command.get_subcommands([](const CLI::App* one) { return one->get_name().empty(); })) {
    for (const CLI::Option* option : group->get_options()) {
      if (option != group->get_help_ptr()) options.push_back(option);
    }
  }
  return options;
}

std::string accepted_numbers(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return fmt::format("{}numbers {}", value_name(type.substr(0, type.find(':'))) == "N" ? "whole " : "",
                     range_text(type.substr(type.find(':') + 1)));
}

OptionShape shape_of(const CLI::Option& option) {
  OptionShape shape;
  shape.about = option.get_description();
  shape.positional = option.get_positional();
  shape.required = option.get_required();
  shape.repeatable = option.get_expected_max() > 1;
  if (shape.positional) {
    shape.names = {option.get_name(true, false)};
  } else {
    for (const std::string& name : option.get_snames()) shape.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) shape.names.push_back("--" + name);
  }
  if (option.get_type_size() == 0) return shape;
  const std::string type = option.get_type_name();
  const std::size_t colon = std::min(type.find(':'), type.size());
  const std::string validators = type.substr(std::min(colon + 1, type.size()));
  shape.choices = words_of(validators);
  shape.value = shape.choices.empty() ? value_name(type.substr(0, colon))
                                      : fmt::format("{}", fmt::join(shape.choices, "|"));
  if (shape.value.size() > 24) {
    shape.value = value_name(type.substr(0, colon));
    shape.about += fmt::format("; one of {}", fmt::join(shape.choices, ", "));
  }
  if (const std::string range = range_text(validators); !range.empty()) shape.about += "; " + range;
  // CLI11 writes a list as "[1,10]"; it is given without brackets.
  if (const std::string given = option.get_default_str(); !given.empty()) {
    const bool list = given.starts_with('[') && given.ends_with(']');
    shape.about += fmt::format(" (default {})", list ? given.substr(1, given.size() - 2) : given);
  }
  return shape;
}

std::vector<CommandShape> command_shapes(const CLI::App& app) {
  std::vector<CommandShape> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    CommandShape& shape = commands.emplace_back(CommandShape{
        command->get_name(), command->get_description(), command->get_group(), command->get_footer(), {}});
    for (const bool positional : {true, false}) {
      for (const CLI::Option* option : options_of(*command)) {
        if (option->get_positional() == positional) shape.options.push_back(shape_of(*option));
      }
    }
  }
  return commands;
}

void dress_commands(CLI::App& app) {
  const auto formatter = std::make_shared<HelpFormatter>();
  app.formatter(formatter);
  app.set_help_flag("-h,--help", "this help");
  app.set_version_flag("--version", version_text(), "version and commit");
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    command->formatter(formatter);
    command->set_help_flag("-h,--help", "this help");
    command->set_version_flag("--version", version_text(), "version and commit");
    command->group(group_of(command->get_name()));
    for (CLI::Option* option : command->get_options()) {
      const OptionShape shape = shape_of(*option);
      if (shape.positional || shape.value.empty()) continue;
      option->check([kind = shape.value](const std::string& text) { return problem_of_value(kind, text); });
    }
  }
}

}  // namespace credence::internal
