#include "datasets/logs/number_field.h"

#include <gtest/gtest.h>

#include <limits>
#include <string_view>
#include <vector>

namespace credence::internal {
namespace {

TEST(NumberField, a_number_is_read_as_the_nearest_double) {
  EXPECT_EQ(parse_finite("0.1"), 0.1);
  EXPECT_EQ(parse_finite("-1e3"), -1000.0);
  EXPECT_EQ(parse_finite("5."), 5.0);
  EXPECT_EQ(parse_finite(".5"), 0.5);
  EXPECT_EQ(parse_finite("1.7976931348623157e308"), std::numeric_limits<double>::max());
  EXPECT_EQ(parse_finite("5e-324"), std::numeric_limits<double>::denorm_min());
  EXPECT_EQ(parse_finite("007"), 7.0);
  EXPECT_EQ(parse_finite("+0.5"), 0.5);
  EXPECT_EQ(parse_finite("1e-400"), 0.0);
  EXPECT_EQ(parse_finite("-1e-400"), 0.0);
}

TEST(NumberField, anything_else_is_none) {
  for (const char* field :
       {"",    " ",   "nan", "-nan", "inf",    "-inf", "infinity", "1e309", "1 ",  " 1", "1,5", "1e", "0x10",
        "--1", "+-1", "++1", "+",    "+1e309", "+nan", "1e-400x",  "1.2.3", "one", "-",  ".",   "1d3"}) {
    EXPECT_FALSE(parse_finite(field).has_value()) << field;
  }
  EXPECT_FALSE(parse_finite(std::string_view("1\0", 2)).has_value());
  EXPECT_EQ(parse_finite(std::string_view("12", 1)), 1.0) << "not beyond its end";
}

TEST(NumberField, what_is_shown_is_short_and_without_control_characters) {
  EXPECT_EQ(shown_field("plain text ~"), "plain text ~");
  EXPECT_EQ(shown_field(std::string_view("a\0\n\x1b\x7f\xff", 6)), "a?\?\?\?\?");
  EXPECT_EQ(shown_field(std::string(1000, 'x')), std::string(24, 'x'));
  EXPECT_EQ(shown_field(""), "");
}

TEST(NumberField, LinesAreTakenApartAtCommasOrBetweenBlanks) {
  using Fields = std::vector<std::string_view>;
  EXPECT_EQ(comma_fields("a, b\t,,c d,"), (Fields{"a", "b", "", "c d", ""}));
  EXPECT_EQ(comma_fields(""), Fields{""});
  EXPECT_EQ(comma_fields(R"("a", "1.5" ,"",",")"), (Fields{"a", "1.5", "", "\"", "\""}));
  EXPECT_EQ(words_between(" \t,", " a,\tb  c "), (Fields{"a", "b", "c"}));
  EXPECT_EQ(words_between(" \t", " \t"), Fields{});
}

}  // namespace
}  // namespace credence::internal
