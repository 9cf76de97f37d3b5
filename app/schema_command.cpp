#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/embedded_files.h"
#include "reports/document/scenario_json_schema.h"
#include "reports/render/json_numbers.h"

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

/// That of the command, as it is in its file.
std::string_view schema_text(std::string_view name) {
  const auto file = std::ranges::find(
      embedded_files(), fmt::format("{}{}{}", kSchemaFolder, name, kSchemaEnding), &EmbeddedFile::path);
  if (file == embedded_files().end()) {
    throw std::invalid_argument(fmt::format("schema: \"{}\" has none; one of {}, {}", name, kScenarioSchema,
                                            fmt::join(described_documents(), ", ")));
  }
  return file->text;
}

/// Its references to its own parts, where it is part of another schema itself.
void move_references(Json& schema, std::string_view to) {
  for (auto& [key, inner] : schema.items()) {
    if (key == "$ref") inner = fmt::format("{}{}", to, inner.get<std::string>().substr(1));
    if (inner.is_structured()) move_references(inner, to);
  }
}

/// The same; of one that is either of other files' schemas these are inside, so that whoever has it needs no
/// other file.
std::string whole_schema(std::string_view name) {
  const std::string_view text = schema_text(name);
  Json schema = Json::parse(text);
  Json files = Json::object();
  if (!schema.contains("anyOf")) return std::string(text);
  for (Json& either : schema["anyOf"]) {
    const std::string file = either.value("$ref", "");
    if (!file.ends_with(kSchemaEnding)) continue;
    const std::string other = file.substr(0, file.size() - kSchemaEnding.size());
    either["$ref"] = "#/$defs/" + other;
    files[other] = Json::parse(schema_text(other));
    files[other].erase("$schema");
    move_references(files[other], "#/$defs/" + other);
  }
  if (files.empty()) return std::string(text);
  schema["$defs"] = std::move(files);
  return text_of_json(schema) + "\n";
}

int schema(const std::string& name) {
  fmt::print("{}", name == kScenarioSchema ? scenario_json_schema() : whole_schema(name));
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
