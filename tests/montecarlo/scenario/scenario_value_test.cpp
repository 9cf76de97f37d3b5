#include "montecarlo/scenario/scenario_value.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

namespace credence::internal {
namespace {

TEST(ScenarioValue, RealsReadBackTheSameAndAreFloats) {
  EXPECT_EQ(real_text(1.0), "1.0");
  EXPECT_EQ(real_text(-0.0), "-0.0");
  EXPECT_EQ(real_text(0.1), "0.1");
  EXPECT_EQ(real_text(1e22), "1e+22");
  EXPECT_EQ(real_text(std::numeric_limits<double>::infinity()), "inf");
  std::mt19937_64 bits(3);
  for (int i = 0; i < 10'000; ++i) {
    const auto value = std::bit_cast<double>(bits());
    if (!std::isfinite(value)) continue;
    const std::string text = real_text(value);
    ASSERT_EQ(std::strtod(text.c_str(), nullptr), value) << text;
    ASSERT_NE(text.find_first_of(".e"), std::string::npos) << text << " would be an integer";
  }
}

TEST(ScenarioValue, StringsAreQuotedAsTomlAsks) {
  EXPECT_EQ(quoted_text("a \"b\" \\ c"), R"("a \"b\" \\ c")");
  EXPECT_EQ(quoted_text("line\nbell\a"), R"("line\u000Abell\u0007")");
  EXPECT_EQ(quoted_text(std::string("nil\0del\x7f", 8)), R"("nil\u0000del\u007F")");
  EXPECT_EQ(quoted_text("σ"), "\"σ\"") << "what is no control character is left alone";
}

TEST(ScenarioValue, ForeignTextIsCutBetweenCharacters) {
  EXPECT_EQ(shown_text("short \"text\""), "short \"text\"");
  EXPECT_EQ(shown_text("abcdef", 6), "abcdef");
  EXPECT_EQ(shown_text("abcdef", 5), "abcde...");
  // Two, three and four bytes of UTF-8, cut before each of them.
  for (const std::string character : {"σ", "€", "😀"}) {
    for (std::size_t longest = 3; longest < 3 + character.size(); ++longest) {
      EXPECT_EQ(shown_text("abc" + character + "d", longest), "abc...") << character << longest;
    }
    EXPECT_EQ(shown_text("abc" + character + "d", 3 + character.size()), "abc" + character + "...");
  }
  EXPECT_EQ(shown_text("\x1b[31m"), "\\u001B[31m") << "no colour on a terminal";
  EXPECT_EQ(shown_text("\x80\x80\x80\x80", 2), "...") << "what is no UTF-8 ends, too";
}

TEST(ScenarioValue, ValuesAreWrittenAsToml) {
  EXPECT_EQ(value_text(SettingValue(ScalarValue(true))), "true");
  EXPECT_EQ(value_text(SettingValue(ScalarValue(std::int64_t{-3}))), "-3");
  EXPECT_EQ(value_text(SettingValue(ScalarValue(2.0))), "2.0");
  EXPECT_EQ(value_text(SettingValue(ScalarValue(std::string("word")))), "\"word\"");
  EXPECT_EQ(value_text(SettingValue(ScalarValue(OtherValue{"date"}))), "date");
  const NestedArray rows{{1.0, std::int64_t{2}}, {}, {std::string("x")}};
  EXPECT_EQ(full_text(rows), "[[1.0, 2], [], [\"x\"]]");
  EXPECT_EQ(full_text(std::vector<ScalarValue>{}), "[]");
}

TEST(ScenarioValue, OnlyMessagesAreCut) {
  const std::vector<ScalarValue> many(1000, ScalarValue(1.5));
  const std::string whole = full_text(many), shown = value_text(SettingValue(many));
  EXPECT_EQ(whole.size(), 1000 * 5);  // "1.5, " each; of the last, brackets in the place of the comma
  EXPECT_EQ(shown.substr(60), "...");
  EXPECT_EQ(whole.substr(0, 60), shown.substr(0, 60));
  const NestedArray long_row{many};
  EXPECT_EQ(value_text(SettingValue(long_row)).size(), 63U);
  const ScalarValue word(std::string(100'000, 'w'));
  EXPECT_EQ(value_text(word).size(), 63U);
  EXPECT_EQ(full_text(word).size(), 100'002U);
}

TEST(ScenarioValue, TypesHaveTheirArticle) {
  EXPECT_EQ(type_text(ScalarValue(false)), "the boolean");
  EXPECT_EQ(type_text(ScalarValue(std::int64_t{1})), "the integer");
  EXPECT_EQ(type_text(ScalarValue(1.0)), "the number");
  EXPECT_EQ(type_text(ScalarValue(std::string("a"))), "the string");
  EXPECT_EQ(type_text(std::vector<ScalarValue>{}), "the array");
  EXPECT_EQ(type_text(NestedArray{{}}), "the array");
}

TEST(ScenarioValue, AMisspellingIsTheNearestWord) {
  const std::vector<std::string_view> words = {"landmarks", "landmark_sensor", "anchors", "dt", "full"};
  EXPECT_EQ(closest_word("landmark", words), "landmarks");
  EXPECT_EQ(closest_word("lnadmarks", words), "landmarks");  // two replaced
  EXPECT_EQ(closest_word("landmarksensor", words), "landmark_sensor");
  EXPECT_EQ(closest_word("anker", words), "")
      << "anchors is three edits off, of five letters two are allowed";
  EXPECT_EQ(closest_word("dtt", words), "dt");
  EXPECT_EQ(closest_word("xy", words), "") << "all short words are two edits apart";
  EXPECT_EQ(closest_word("", words), "");
  EXPECT_EQ(closest_word(std::string(61, 'a'), words), "") << "too long to be one";
  // The textbook's distance of three: of nine letters a third may differ, of six two.
  EXPECT_EQ(closest_word("sittingly", {"kittenly"}), "kittenly");
  EXPECT_EQ(closest_word("kitten", {"sitting"}), "");
}

}  // namespace
}  // namespace credence::internal
