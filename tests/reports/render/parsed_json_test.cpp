#include "reports/render/parsed_json.h"

#include <gmock/gmock.h>

#include <stdexcept>

namespace credence::internal {
namespace {

std::string json_error(const std::string& text) {
  try {
    parsed_json("a.json", text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(ParsedJson, WhatIsNoneIsNamedByLineAndColumn) {
  EXPECT_EQ(parsed_json("a.json", R"({"x": 2})")["x"], 2);
  EXPECT_EQ(json_error(""), "a.json: is empty, and no JSON");
  EXPECT_EQ(json_error(" \n"), "a.json: is empty, and no JSON");
  EXPECT_EQ(json_error("[model]\n"), "a.json:1: is no JSON, from column 2 on");
  EXPECT_EQ(json_error("{\n\"x\": 1,\n\n  y\n}"), "a.json:4: is no JSON, from column 3 on");
  EXPECT_EQ(json_error("[1e999]"), "a.json: is no JSON: a number in it is beyond all numbers");
  EXPECT_THAT(json_error(std::string(100'000, '[')), ::testing::StartsWith("a.json:1: is no JSON"));
}

TEST(ParsedJson, DocumentsOfAnotherSchemaAreRefused) {
  EXPECT_NO_THROW(require_schema("a.json", Json{{"schema", kSchema}}));
  EXPECT_NO_THROW(require_schema("a.json", Json{{"other", 1}}));
  EXPECT_NO_THROW(require_schema("a.json", Json(1)));
  for (const Json& schema : {Json(kSchema + 1), Json("1"), Json(nullptr)})
    EXPECT_THROW(require_schema("a.json", Json{{"schema", schema}}), std::invalid_argument) << schema;
}

}  // namespace
}  // namespace credence::internal
