#include "montecarlo/scenario/scenario_help.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_schema.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> lines_of_help() {
  std::istringstream text(scenario_help());
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::ptrdiff_t columns(const std::string& line) {
  return std::ranges::count_if(line, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; });
}

/// The lines of one key, joined by blanks.
std::string about(const std::string& head) {
  const std::vector<std::string> lines = lines_of_help();
  auto at =
      std::ranges::find_if(lines, [&](const std::string& line) { return line.starts_with("  " + head); });
  if (at == lines.end()) return "";
  std::string text = at->substr(2);
  for (++at; at != lines.end() && at->starts_with("      "); ++at) text += " " + at->substr(6);
  return text;
}

TEST(ScenarioHelp, says_what_a_key_is_in_lines_of_at_most_a_hundred_columns) {
  for (const std::string& line : lines_of_help()) {
    if (line.starts_with("      ")) {
      EXPECT_LE(columns(line), 100) << line;
    }
    EXPECT_FALSE(line.ends_with(' ')) << line;
  }
}

TEST(ScenarioHelp, fills_its_lines) {
  const std::vector<std::string> lines = lines_of_help();
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    if (!lines[i].starts_with("      ") || !lines[i + 1].starts_with("      ")) continue;
    const std::string next = lines[i + 1].substr(6, lines[i + 1].find(' ', 6) - 6);
    EXPECT_GT(lines[i].size() + 1 + next.size(), 100U) << "there was room for \"" << next << "\"";
  }
}

TEST(ScenarioHelp, tells_default_unit_values_and_where) {
  EXPECT_THAT(
      about("process_variance"),
      HasSubstr("process_variance = 0.1 m^2 Q, variance of the vehicle's motion in one step; a finite "
                "number >= 0; only with world.model = \"monobot\""));
  EXPECT_THAT(about("runs"), HasSubstr("runs = 200 independent runs; an integer from 1 to 1000000000"));
  EXPECT_THAT(about("model"), HasSubstr("= required "));
  EXPECT_THAT(about("position_std = 0.05,"), HasSubstr("10.0 with \"tracking\""))
      << "a default that a world has changed is told with its name";
}

TEST(ScenarioHelp, and_reference_have_every_section_in_its_order) {
  const std::string help = scenario_help(), reference = scenario_reference();
  std::size_t in_help = 0, in_reference = 0;
  for (const std::string_view section : scenario_sections()) {
    const std::size_t a = help.find("[" + std::string(section) + "]\n");
    const std::size_t b = reference.find("### `[" + std::string(section) + "]`");
    ASSERT_NE(a, std::string::npos) << section;
    ASSERT_NE(b, std::string::npos) << section;
    EXPECT_GE(a, in_help);
    EXPECT_GE(b, in_reference);
    in_help = a;
    in_reference = b;
  }
}

TEST(ScenarioReference, has_one_row_of_five_cells_for_every_key) {
  std::istringstream text(scenario_reference());
  std::size_t rows = 0;
  for (std::string line; std::getline(text, line);) {
    if (!line.starts_with("| `")) continue;
    ++rows;
    EXPECT_EQ(std::ranges::count(line, '|'), 6) << line;
  }
  EXPECT_EQ(rows, scenario_keys().size());
}

}  // namespace
}  // namespace credence::internal
