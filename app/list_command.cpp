#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/command_tree.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/scenario_files.h"
#include "app/terminal_text.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

struct ListOptions : CommonOptions {
  std::string what;
};

/// One kind of thing, each with what it is.
struct Listing {
  std::string key, title;
  std::vector<std::pair<std::string, std::string>> entries;
};

std::vector<Listing> listings(const CLI::App& app) {
  Listing scenarios{
      "scenarios", "Scenarios that come with the program: credence run NAME, credence sweep NAME", {}};
  for (const OwnScenario& s : own_scenarios()) {
    scenarios.entries.emplace_back(s.name, fmt::format("{}{}", s.sweep ? "(sweep) " : "", s.title));
  }
  Listing kinds{"worlds", "Worlds: world.model of a scenario", {}};
  for (const World* world : worlds()) kinds.entries.emplace_back(world->schema.name, world->schema.meaning);
  Listing commands{"commands", "Commands: credence help COMMAND", {}};
  for (const CommandShape& command : command_shapes(app))
    commands.entries.emplace_back(command.name, command.about);
  return {scenarios, kinds, commands};
}

int list(const CLI::App& app, const ListOptions& options) {
  nlohmann::ordered_json document;
  bool first = true;
  for (const Listing& listing : listings(app)) {
    if (!options.what.empty() && options.what != listing.key) continue;
    ReportTable table{
        listing.title, {{"name", ColumnAlign::words}, {"what it is", ColumnAlign::words}}, {}, {}};
    document[listing.key] = nlohmann::json::array();
    for (const auto& [name, about] : listing.entries) {
      table.add({name, about});
      document[listing.key].push_back({{"name", name}, {"about", about}});
    }
    if (options.format == "text") fmt::print("{}{}", first ? "" : "\n", terminal_text(table));
    first = false;
  }
  if (options.format == "json") fmt::print("{}\n", document.dump(1));
  return kDone;
}

}  // namespace

void add_list_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("list", "the scenarios that come with the program, worlds, commands");
  auto options = std::make_shared<ListOptions>();
  command->add_option("what", options->what, "only these")
      ->check(CLI::IsMember({"scenarios", "worlds", "commands"}));
  add_print_options(*command, *options, {"text", "json"});
  static constexpr const char* kExamples[] = {"credence list", "credence list scenarios --format json"};
  command->footer(examples(kExamples));
  command->callback([options, &app] { throw ExitStatus{list(app, *options)}; });
}

}  // namespace credence::internal
