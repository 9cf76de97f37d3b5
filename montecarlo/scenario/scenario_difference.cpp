#include "montecarlo/scenario/scenario_difference.h"

#include <fmt/format.h>

#include <map>

namespace credence::internal {
namespace {

/// section.key → value. Canonical texts have one key a line.
std::map<std::string, std::string> values_of(std::string_view text) {
  std::map<std::string, std::string> values;
  std::string section;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.empty()) continue;
    const std::size_t equals = line.find(" = ");
    if (line.front() == '[' && line.back() == ']' && equals == std::string_view::npos) {
      section = line.substr(1, line.size() - 2);
    } else {
      const std::string_view value = equals == std::string_view::npos ? "" : line.substr(equals + 3);
      values[fmt::format("{}.{}", section, line.substr(0, equals))] = value;
    }
  }
  // They do not change what is computed in a run.
  std::erase_if(values, [](const auto& value) {
    return value.first == "study.runs" || value.first == "study.confidence" ||
           value.first.starts_with("study.stop.");
  });
  return values;
}

}  // namespace

std::string scenario_difference(std::string_view stored, std::string_view asked) {
  std::map<std::string, std::string> keys = values_of(stored);
  const std::map<std::string, std::string> before = keys, after = values_of(asked);
  keys.insert(after.begin(), after.end());
  std::string text;
  for (const auto& [key, unused] : keys) {
    const auto old_value = before.find(key), new_value = after.find(key);
    const bool is_old = old_value != before.end(), is_new = new_value != after.end();
    if (is_old && is_new && old_value->second == new_value->second) continue;
    if (is_old) text += fmt::format("- {} = {}\n", key, old_value->second);
    if (is_new) text += fmt::format("+ {} = {}\n", key, new_value->second);
  }
  return text;
}

}  // namespace credence::internal
