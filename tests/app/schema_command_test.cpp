#include <gmock/gmock.h>

#include <string>

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

}  // namespace
}  // namespace credence::internal
