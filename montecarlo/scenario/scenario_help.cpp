#include "montecarlo/scenario/scenario_help.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "core/append_item.h"
#include "montecarlo/scenario/scenario_schema.h"

namespace credence::internal {
namespace {

constexpr std::size_t kWidth = 100;

/// The default in the worlds that have the key: of the first and those like it, then each other one with its
/// worlds. Anchors count from the observability that needs them.
std::string default_text(const ScenarioKey& key) {
  if (!key.default_words.empty()) return std::string(key.default_words);
  std::vector<std::pair<std::string, std::string>> worlds_of_value;
  for (const ScenarioKey::Use& use : key.uses) {
    const std::string value = value_text(key_value(key, starting_scenario(use.world)));
    auto same = std::ranges::find(worlds_of_value, value, &std::pair<std::string, std::string>::first);
    if (same == worlds_of_value.end()) same = worlds_of_value.insert(same, {value, ""});
    append_item(same->second, fmt::format("\"{}\"", use.world), " or ");
  }
  std::string text;
  for (const auto& [value, worlds] : worlds_of_value)
    append_item(text, text.empty() ? value : fmt::format("{} with {}", value, worlds));
  return text;
}

std::string with_unit(const std::string& text, std::string_view unit) {
  return unit.empty() ? text : fmt::format("{} {}", text, unit);
}

/// The text in lines that begin with `indent` blanks, broken between words.
std::string wrapped(std::string_view text, std::size_t indent) {
  std::string lines, line;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    if (!line.empty() && indent + line.size() + 1 + word.size() > kWidth) {
      lines += fmt::format("{:{}}{}\n", "", indent, line);
      line.clear();
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  return lines + fmt::format("{:{}}{}\n", "", indent, line);
}

std::string only_text(const ScenarioKey& key) {
  const std::string where = key.accepted_where();
  return where.empty() ? "" : fmt::format("; only {}", where);
}

std::string code(std::string_view text) { return fmt::format("`{}`", text); }

}  // namespace

std::string scenario_help() {
  std::string text;
  for (const std::string_view section : scenario_sections()) {
    text += fmt::format("[{}]\n", section);
    for (const ScenarioKey& key : scenario_keys()) {
      if (key.section != section) continue;
      text += fmt::format("  {} = {}\n", key.name, with_unit(default_text(key), key.unit));
      std::string about = fmt::format("{}; {}", key.meaning, accepted_values(key));
      about += only_text(key);
      text += wrapped(about, 6);
    }
  }
  return text;
}

std::string scenario_reference() {
  std::string text;
  for (const std::string_view section : scenario_sections()) {
    text += fmt::format(
        "### `[{}]`\n\n| key | default | unit | accepted | meaning |\n|---|---|---|---|---|\n", section);
    for (const ScenarioKey& key : scenario_keys()) {
      if (key.section != section) continue;
      text += fmt::format("| {} | {} | {} | {}{} | {} |\n", code(key.name), code(default_text(key)), key.unit,
                          accepted_values(key), only_text(key), key.meaning);
    }
    text += "\n";
  }
  return text;
}

}  // namespace credence::internal
