#include "montecarlo/scenario/scenario_io.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

#include "core/trim_blanks.h"
#include "montecarlo/scenario/scenario_resolve.h"
#include "montecarlo/scenario/scenario_schema.h"

namespace credence::internal {
namespace {

constexpr std::size_t kLargestFile = 1 << 20;

/// /dev/stdin, /dev/fd/63, /proc/self/fd/0.
bool is_of_shell(const std::filesystem::path& file) {
  const std::string name = file.string();
  return name.starts_with("/dev/") || name.starts_with("/proc/");
}

std::string read_text(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::status_known(status)) {
    throw ScenarioError(fmt::format("{}: cannot be read ({})", file.string(), error.message()));
  }
  if (!std::filesystem::exists(status)) {
    throw ScenarioError(fmt::format("{}: no such scenario file", file.string()));
  }
  if (std::filesystem::is_directory(status)) {
    throw ScenarioError(fmt::format("{}: is a directory; a scenario is a TOML file", file.string()));
  }
  // A pipe of the shell has its writer; one of another name would be waited for.
  if (std::filesystem::is_fifo(status) && !is_of_shell(file)) {
    throw ScenarioError(fmt::format("{}: is a pipe; a scenario is a TOML file", file.string()));
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw ScenarioError(fmt::format("{}: cannot be read ({})", file.string(), std::strerror(errno)));
  }
  std::string text(kLargestFile + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kLargestFile) {
    throw ScenarioError(
        fmt::format("{}: is larger than 1 MiB; a scenario is a short TOML file", file.string()));
  }
  return text;
}

ScalarValue scalar_value(const toml::node& node) {
  if (const auto* boolean = node.as_boolean()) return boolean->get();
  if (const auto* integer = node.as_integer()) return integer->get();
  if (const auto* real = node.as_floating_point()) return real->get();
  if (const auto* text = node.as_string()) return text->get();
  if (node.is_table()) return OtherValue{"a table"};
  if (node.is_array()) return OtherValue{"an array"};
  return OtherValue{"a date or time"};
}

std::vector<ScalarValue> scalar_values(const toml::array& array) {
  std::vector<ScalarValue> values;
  for (const toml::node& element : array) values.push_back(scalar_value(element));
  return values;
}

SettingValue setting_value(const toml::node& node) {
  const auto* array = node.as_array();
  if (array == nullptr) return scalar_value(node);
  if (array->empty() || !array->is_homogeneous(toml::node_type::array)) return scalar_values(*array);
  NestedArray rows;
  for (const toml::node& element : *array) rows.push_back(scalar_values(*element.as_array()));
  return rows;
}

/// The dot between section and key: behind the longest section that there is, else the first.
std::size_t section_end(const std::string& path) {
  std::size_t dot = path.find('.');
  for (const std::string_view section : scenario_sections()) {
    const bool fits =
        path.starts_with(section) && path.size() > section.size() && path[section.size()] == '.';
    if (fits && section.size() > dot) dot = section.size();
  }
  return dot;
}

Setting make_setting(const std::string& path, SettingValue value, std::string place) {
  const std::size_t dot = section_end(path);
  const bool dotted = dot != std::string::npos;
  return {dotted ? path.substr(0, dot) : "", dotted ? path.substr(dot + 1) : path, std::move(value),
          std::move(place)};
}

/// Collects the settings of one parsed file, with their positions, since a table forgets the order of its
/// keys.
class SettingCollector {
 public:
  explicit SettingCollector(const std::string& file) : file_(file) {}

  void add_file(const toml::table& root) {
    for (const auto& [key, node] : root) {
      const auto* table = node.as_table();
      if (table != nullptr && key.str() == "sweep") {
        add_sweep("", *table);
      } else if (table != nullptr) {
        add_section(std::string(key.str()), *table);
      } else {
        add(settings_, "", std::string(key.str()), node, "");
      }
    }
  }

  void move_into(ScenarioDocument& document) {
    document.settings = in_order(settings_);
    document.sweep = in_order(sweep_);
  }

 private:
  using Positioned = std::pair<toml::source_position, Setting>;

  void add(std::vector<Positioned>& list, std::string section, std::string key, const toml::node& node,
           const std::string& heading) {
    SettingValue value = setting_value(node);
    std::string place = fmt::format("{}:{}: {}{} = {}", file_, node.source().begin.line, heading,
                                    shown_text(key), value_text(value));
    list.emplace_back(node.source().begin,
                      Setting{std::move(section), std::move(key), std::move(value), std::move(place)});
  }

  void add_section(const std::string& section, const toml::table& table) {
    const auto known = scenario_sections();
    if (table.empty() && std::find(known.begin(), known.end(), section) == known.end()) {
      // It says nothing, but its misspelt name says that something was meant.
      std::string place = fmt::format("{}:{}: [{}]", file_, table.source().begin.line, shown_text(section));
      settings_.emplace_back(table.source().begin,
                             Setting{section, "", ScalarValue{OtherValue{"a table"}}, std::move(place)});
    }
    for (const auto& [key, node] : table) {
      const std::string inner = fmt::format("{}.{}", section, key.str());
      if (node.is_table() && std::find(known.begin(), known.end(), inner) != known.end()) {
        add_section(inner, *node.as_table());
        continue;
      }
      add(settings_, section, std::string(key.str()), node, fmt::format("[{}] ", shown_text(section)));
    }
  }

  /// Dotted keys, quoted dotted keys and nested tables of [sweep] all name section.key.
  void add_sweep(const std::string& prefix, const toml::table& table) {
    for (const auto& [key, node] : table) {
      const std::string path = prefix + std::string(key.str());
      if (const auto* inner = node.as_table()) {
        add_sweep(path + ".", *inner);
        continue;
      }
      SettingValue value = setting_value(node);
      std::string place = fmt::format("{}:{}: [sweep] {} = {}", file_, node.source().begin.line,
                                      shown_text(path), value_text(value));
      sweep_.emplace_back(node.source().begin, make_setting(path, std::move(value), std::move(place)));
    }
  }

  static std::vector<Setting> in_order(std::vector<Positioned>& list) {
    std::stable_sort(list.begin(), list.end(), [](const Positioned& a, const Positioned& b) {
      return std::pair(a.first.line, a.first.column) < std::pair(b.first.line, b.first.column);
    });
    std::vector<Setting> settings;
    settings.reserve(list.size());
    for (Positioned& element : list) settings.push_back(std::move(element.second));
    return settings;
  }

  const std::string& file_;
  std::vector<Positioned> settings_;
  std::vector<Positioned> sweep_;
};

std::string_view line_text(std::string_view text, std::size_t line) {
  for (; line > 1 && text.find('\n') != std::string_view::npos; --line)
    text.remove_prefix(text.find('\n') + 1);
  return text.substr(0, text.find_first_of("\r\n"));
}

/// Passes over what is quoted at `at`, or over a comment.
std::size_t behind_quotes(std::string_view text, std::size_t at) {
  const char mark = text[at];
  if (mark == '#') return std::min(text.find('\n', at), text.size());
  const std::string three(3, mark);
  const bool lines = text.substr(at).starts_with(three);
  const std::string_view end = std::string_view(three).substr(0, lines ? 3 : 1);
  for (std::size_t i = at + end.size(); i < text.size(); ++i) {
    if (text.substr(i).starts_with(end)) return i + end.size();
    if (text[i] == '\n' && !lines) return i;
    if (text[i] == '\\' && mark == '"') ++i;
  }
  return text.size();
}

/// The first line with a key of more than 1000 dots, together with those of the keys that it stands in; 0:
/// none. Each dot is a table in a table, and toml++ as well as its destructors call themselves for each: keys
/// of tens of thousands of dots end in a stack overflow.
std::size_t line_nested_too_deep(std::string_view text) {
  constexpr std::size_t kMostDots = 1000;
  std::size_t line = 1, dots = 0;
  std::vector<std::size_t> outer{0};  // dots of what the open brackets are the value of
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'' || c == '#') {
      const std::size_t end = behind_quotes(text, i);
      line += static_cast<std::size_t>(std::ranges::count(text.substr(i, end - i), '\n'));
      i = end;
      continue;
    }
    if (c == '.' && outer.back() + ++dots > kMostDots) return line;
    if (c == '[' || c == '{') outer.push_back(outer.back() + dots);
    if ((c == ']' || c == '}') && outer.size() > 1) outer.pop_back();
    if (std::string_view("[]{},\n").find(c) != std::string_view::npos) dots = 0;
    line += c == '\n' ? 1U : 0U;
    ++i;
  }
  return 0;
}

toml::table parse_toml(std::string_view text, const std::string& file) {
  if (const std::size_t line = line_nested_too_deep(text); line > 0) {
    throw ScenarioError(fmt::format("{}:{}: {}: has a key of more than 1000 dots", file, line,
                                    shown_text(line_text(text, line))));
  }
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    const std::size_t line = error.source().begin.line;
    throw ScenarioError(fmt::format("{}:{}: {}: broken TOML at column {}: {}", file, line,
                                    shown_text(line_text(text, line)), error.source().begin.column,
                                    shown_text(error.description(), 200)));
  }
}

/// A TOML value, or else the text itself as a string.
SettingValue override_value(const std::string& text) {
  if (text.find_first_of("\r\n") == std::string::npos && line_nested_too_deep(text) == 0) {
    try {
      const toml::table table = toml::parse("value = " + text);
      if (table.size() == 1) return setting_value(*table.get("value"));
    } catch (const toml::parse_error&) {
      return ScalarValue{text};
    }
  }
  return ScalarValue{text};
}

/// A list of sweep values is not read as TOML unless it is an array or a quoted string: "10:10:50" would be
/// a time of day.
SettingValue sweep_override_value(const std::string& text) {
  const bool is_toml = !text.empty() && (text.front() == '[' || text.front() == '"' || text.front() == '\'');
  return is_toml ? override_value(text) : SettingValue{ScalarValue{text}};
}

bool same_key(const Setting& a, const Setting& b) { return a.section == b.section && a.key == b.key; }

void replace_or_add(std::vector<Setting>& settings, Setting setting) {
  const auto same = std::find_if(settings.begin(), settings.end(),
                                 [&](const Setting& other) { return same_key(setting, other); });
  if (same == settings.end()) {
    settings.push_back(std::move(setting));
  } else {
    *same = std::move(setting);
  }
}

void apply_override(ScenarioDocument& document, const std::string& text) {
  const std::size_t equals = std::min(text.find('='), text.size());
  const std::string path(trim_blanks(std::string_view(text).substr(0, equals)));
  const std::size_t dot = section_end(path);
  if (equals == text.size() || dot == 0 || dot == std::string::npos || dot + 1 == path.size()) {
    const std::string meant = dot == std::string::npos ? keys_without_section(path) : "";
    throw ScenarioError(fmt::format(
        "--set {}: must be section.key=value, {}", shown_text(text),
        meant.empty() ? "such as noise.process_variance=0.2" : fmt::format("did you mean {}?", meant)));
  }
  const std::string section = path.substr(0, dot);
  const std::string key = path.substr(dot + 1);
  const std::string value(trim_blanks(std::string_view(text).substr(equals + 1)));
  std::string place = fmt::format("--set {}={}", shown_text(path), shown_text(value));
  if (section == "sweep") {
    replace_or_add(document.sweep, make_setting(key, sweep_override_value(value), std::move(place)));
  } else {
    replace_or_add(document.settings, {section, key, override_value(value), std::move(place)});
  }
}

/// A key of [sweep] can be written in three ways, of which TOML sees no duplicate.
void refuse_duplicates(const std::vector<Setting>& sweep) {
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!same_key(sweep[i], sweep[j])) continue;
      throw ScenarioError(fmt::format("{}: was given before ({})", sweep[i].place, sweep[j].place));
    }
  }
}

}  // namespace

ScenarioDocument read_scenario_text(std::string_view text, const std::string& file,
                                    std::span<const std::string> overrides) {
  ScenarioDocument document;
  document.file = file;
  document.name = std::filesystem::path(file).stem().string();
  SettingCollector collector(document.file);
  collector.add_file(parse_toml(text, file));
  collector.move_into(document);
  refuse_duplicates(document.sweep);
  for (const std::string& text_of_override : overrides) apply_override(document, text_of_override);
  return document;
}

ScenarioDocument read_scenario(const std::filesystem::path& file, std::span<const std::string> overrides) {
  return read_scenario_text(read_text(file), file.string(), overrides);
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

Scenario load_scenario_text(std::string_view text, const std::string& file,
                            std::span<const std::string> overrides) {
  const ScenarioDocument document = read_scenario_text(text, file, overrides);
  for (const Setting& swept : document.sweep) {
    if (!swept.place.starts_with("--set ")) continue;
    throw ScenarioError(swept.place +
                        ": of one configuration nothing is swept; credence sweep runs them all");
  }
  Scenario scenario = resolve_scenario(document.settings, document.file);
  scenario.name = document.name;
  return scenario;
}

Scenario load_scenario(const std::filesystem::path& file, std::span<const std::string> overrides) {
  return load_scenario_text(read_text(file), file.string(), overrides);
}

}  // namespace credence
