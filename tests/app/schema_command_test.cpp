#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

class SchemaCommand : public CommandTest {};

TEST_F(SchemaCommand, OfTheScenarioHasEveryKeyOfTheHelp) {
  const Json schema = json({"schema"});
  EXPECT_EQ(schema, json({"schema", "scenario"}));
  EXPECT_THAT(schema["$schema"].get<std::string>(), HasSubstr("json-schema.org"));
  for (const char* section : {"world", "noise", "initial", "filter", "study", "sweep"}) {
    EXPECT_TRUE(schema["properties"].contains(section)) << section;
  }
  EXPECT_TRUE(schema["properties"]["world"]["properties"].contains("landmarks"));
  EXPECT_TRUE(schema["properties"]["study"]["properties"]["stop"]["properties"].contains("verdict"));
}

TEST_F(SchemaCommand, EveryOneThatIsOfferedIsThere) {
  const Finished refused = run({"schema", "nothing"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err,
              ::testing::StartsWith("credence: schema: \"nothing\" has none; one of scenario, "));
  std::istringstream names(refused.err.substr(refused.err.find("one of ") + 7));
  int count = 0;
  for (std::string name; names >> name; ++count) {
    if (name.ends_with(',')) name.pop_back();
    EXPECT_TRUE(json({"schema", name}).is_object()) << name;
    if (name != "scenario") EXPECT_EQ(run({"help", name}).code, 0) << name << " is no command";
  }
  EXPECT_GT(count, 10);
}

/// Every reference within it.
void collect_references(const nlohmann::json& schema, std::vector<std::string>& references) {
  for (const auto& [key, inner] : schema.items()) {
    if (key == "$ref") references.push_back(inner.get<std::string>());
    if (inner.is_structured()) collect_references(inner, references);
  }
}

// `show` prints what `run` and `sweep` print: whoever has its schema has all of theirs.
TEST_F(SchemaCommand, OfShowHoldsThoseOfRunAndSweep) {
  const Json schema = json({"schema", "show"});
  ASSERT_EQ(schema["anyOf"].size(), 2U);
  for (const char* command : {"run", "sweep"}) {
    const Json own = json({"schema", command});
    EXPECT_EQ(schema["$defs"][command]["anyOf"].size(), own["anyOf"].size()) << command;
    EXPECT_EQ(schema["$defs"][command]["$defs"].size(), own["$defs"].size()) << command;
  }
  std::vector<std::string> references;
  collect_references(schema, references);
  EXPECT_GT(references.size(), 50U);
  for (const std::string& reference : references) {
    ASSERT_TRUE(reference.starts_with('#')) << reference << " is another file";
    EXPECT_TRUE(schema.contains(Json::json_pointer(reference.substr(1)))) << reference;
  }
}

}  // namespace
}  // namespace credence::internal
