#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/embedded_files.h"
#include "reports/document/scenario_json_schema.h"

namespace credence::internal {
namespace {

constexpr std::string_view kScenarioSchema = "scenario", kSchemaFolder = "docs/schemas/",
                           kSchemaEnding = ".json";

/// Commands whose `--format json` has a schema.
std::vector<std::string> described_documents() {
  std::vector<std::string> names;
  for (const EmbeddedFile& file : embedded_files()) {
    if (!file.path.starts_with(kSchemaFolder)) continue;
    names.emplace_back(file.path.substr(kSchemaFolder.size(),
                                        file.path.size() - kSchemaFolder.size() - kSchemaEnding.size()));
  }
  return names;
}

int schema(const std::string& name) {
  if (name == kScenarioSchema) {
    fmt::print("{}", scenario_json_schema());
    return kDone;
  }
  const auto file = std::ranges::find(
      embedded_files(), fmt::format("{}{}{}", kSchemaFolder, name, kSchemaEnding), &EmbeddedFile::path);
  if (file == embedded_files().end()) {
    throw std::invalid_argument(fmt::format("schema: \"{}\" has none; one of {}, {}", name, kScenarioSchema,
                                            fmt::join(described_documents(), ", ")));
  }
  fmt::print("{}", file->text);
  return kDone;
}

}  // namespace

void add_schema_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("schema", "JSON Schema of the scenario file or of a JSON document");
  auto name = std::make_shared<std::string>(kScenarioSchema);
  command
      ->add_option("of", *name,
                   fmt::format("\"scenario\", or the command that prints the document: {}",
                               fmt::join(described_documents(), ", ")))
      ->capture_default_str();
  static constexpr const char* kExamples[] = {"credence schema > scenario.schema.json",
                                              "credence schema run > run.schema.json"};
  command->footer(examples(kExamples));
  command->callback([name] { throw ExitStatus{schema(*name)}; });
}

}  // namespace credence::internal
