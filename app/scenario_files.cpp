#include "app/scenario_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "app/embedded_files.h"
#include "core/names_in.h"
#include "montecarlo/scenario/leading_comment.h"
#include "montecarlo/scenario/scenario_hash.h"
#include "montecarlo/scenario/scenario_value.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFolder = "scenarios/", kEnding = ".toml";

std::string comment_of(std::string_view text) {
  std::istringstream scenario{std::string(text)};
  return leading_comment(scenario);
}

/// The first sentence of the comment that a text begins with.
std::string first_sentence(std::string_view text) {
  const std::string comment = comment_of(text);
  return comment.substr(0, std::min(comment.find(". "), comment.size() - comment.ends_with('.')));
}

std::optional<OwnScenario> own_scenario(std::string_view name) {
  const std::vector<OwnScenario> all = own_scenarios();
  const auto found = std::ranges::find(all, name, &OwnScenario::name);
  return found == all.end() ? std::nullopt : std::optional(*found);
}

/// What may have been meant by a name that is neither a file nor a scenario of ours.
std::string proposal(const std::string& name) {
  const std::string stem = fs::path(name).stem().string();
  std::error_code error;
  for (const fs::path& file : {fs::path(name + std::string(kEnding)), fs::path(kFolder) / (stem + ".toml")}) {
    if (fs::is_regular_file(file, error)) return fmt::format("; did you mean {}?", file.string());
  }
  const std::string_view close = closest_word(stem, names_in(own_scenarios()));
  return close.empty() ? "; credence list names those that come with the program"
                       : fmt::format("; did you mean {}, which comes with the program?", close);
}

/// The program's scenario that is meant, if no file is.
std::optional<OwnScenario> own_unless_file(const std::string& name) {
  if (name.empty()) throw ScenarioError("the name of a scenario is empty");
  std::error_code error;
  const bool exists = fs::exists(name, error);
  if (exists && !fs::is_directory(name, error)) return std::nullopt;
  std::optional<OwnScenario> own = own_scenario(name);
  if (!own && (exists || error)) return std::nullopt;  // who reads it says what it is
  if (!own) throw ScenarioError(fmt::format("{}: no such scenario file{}", name, proposal(name)));
  return own;
}

}  // namespace

std::vector<OwnScenario> own_scenarios() {
  std::vector<OwnScenario> scenarios;
  for (const EmbeddedFile& file : embedded_files()) {
    if (!file.path.starts_with(kFolder)) continue;
    std::string_view name = file.path.substr(kFolder.size());
    name.remove_suffix(kEnding.size());
    scenarios.push_back(
        {name, first_sentence(file.text), file.text, file.text.find("\n[sweep]") != std::string_view::npos});
  }
  std::ranges::sort(scenarios, {}, &OwnScenario::name);
  return scenarios;
}

bool is_own_scenario(std::string_view name) { return own_scenario(name).has_value(); }

ScenarioDocument open_scenario(const std::string& name, std::span<const std::string> overrides) {
  const std::optional<OwnScenario> own = own_unless_file(name);
  return own ? read_scenario_text(own->text, name, overrides) : read_scenario(name, overrides);
}

Scenario open_one_scenario(const std::string& name, std::span<const std::string> overrides) {
  const std::optional<OwnScenario> own = own_unless_file(name);
  return own ? load_scenario_text(own->text, name, overrides) : load_scenario(name, overrides);
}

std::string scenario_comment(const std::string& name) {
  if (const std::optional<OwnScenario> own = own_unless_file(name)) return comment_of(own->text);
  std::ifstream file(name);
  return leading_comment(file);
}

SweepPlan open_sweep(const std::string& name, std::span<const std::string> overrides) {
  return plan_sweep(open_scenario(name, overrides));
}

std::filesystem::path default_directory(const SweepPlan& plan) {
  return std::filesystem::path("out") /
         fmt::format("{}-{:08x}", plan.name, stable_hash(canonical_toml(plan)) & 0xffffffffU);
}

}  // namespace credence::internal
