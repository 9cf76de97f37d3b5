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

std::string impossible_number(const std::string& result) {
  try {
    require_possible("a.json", Json::parse(result));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(ParsedJson, NumbersThatNoResultHasAreRefusedByFileAndKey) {
  EXPECT_EQ(impossible_number(R"({"runs": -5})"), "a.json: runs = -5: must be a whole number of at least 0");
  EXPECT_EQ(impossible_number(R"({"rows": 2.5})"),
            "a.json: rows = 2.5: must be a whole number of at least 0");
  EXPECT_EQ(impossible_number(R"({"wrongly_certain": [{"count": 1}, {"count": -1}]})"),
            "a.json: wrongly_certain.1.count = -1: must be a whole number of at least 0");
  EXPECT_EQ(impossible_number(R"({"word": {"p_value": 1.5}})"),
            "a.json: word.p_value = 1.5: must lie in [0, 1]");
  EXPECT_EQ(impossible_number(R"({"nees": {"confidence": 0}})"),
            "a.json: nees.confidence = 0: must lie in (0, 1)");
  EXPECT_EQ(impossible_number(R"({"blocks": {"a.b": {"mean": 2}, "c": {"mean": -2}}})"),
            "a.json: blocks.c.mean = -2: must be at least 0");
  EXPECT_EQ(impossible_number(R"({"calibration": {"unit_factors": {"NEES": [1, null, -0.5]}}})"),
            "a.json: calibration.unit_factors.NEES.2 = -0.5: must be at least 0");
  for (const char* place : {"runs", "rows", "rejected_rows", "unmatched_rows", "state_dim"}) {
    for (const char* number : {"-1", "0.5", "1e30", "18446744073709551615"})
      EXPECT_NE(impossible_number(std::string("{\"") + place + "\": " + number + "}"), "") << place << number;
  }
  for (const char* verdict : {"nees", "nis", "vehicle_nees"}) {
    for (const char* wrong :
         {R"("mean": -1)", R"("expected": -1)", R"("p_value": 2)", R"("factor": {"value": -1})"})
      EXPECT_NE(impossible_number(std::string("{\"") + verdict + "\": {" + wrong + "}}"), "")
          << verdict << wrong;
  }
  EXPECT_NE(impossible_number(R"({"sensors": [{"nis": {"expected": -1}}]})"), "");
}

TEST(ParsedJson, LargeNumbersAndWhatIsMissingOrNoNumberArePassedOver) {
  for (const char* fine :
       {R"({"nees": {"mean": 1e308, "expected": 0, "p_value": 1, "confidence": 0.95}, "runs": 5.0})",
        R"({"nees": null, "word": 5, "runs": "x", "blocks": []})",
        R"({"battery": {"scores": {"log": {"mean": -8.4, "expected": -5.4}}}})", "[1]", "3"})
    EXPECT_EQ(impossible_number(fine), "") << fine;
}

}  // namespace
}  // namespace credence::internal
