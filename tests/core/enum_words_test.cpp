#include "core/enum_words.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

enum class Fruit { apple, pear, plum };

std::string_view to_string(Fruit fruit) { return word_of(fruit, {"apple", "pear", "plum"}); }

TEST(EnumWords, AreInTheOrderOfTheValues) {
  EXPECT_EQ(to_string(Fruit::apple), "apple");
  EXPECT_EQ(to_string(Fruit::plum), "plum");
  EXPECT_EQ(to_string(static_cast<Fruit>(3)), "");
}

TEST(EnumWords, TellTheirValue) {
  EXPECT_EQ(value_named("pear", Fruit::plum), Fruit::pear);
  EXPECT_EQ(value_named("plum", Fruit::plum), Fruit::plum);
  EXPECT_FALSE(value_named("plum", Fruit::pear).has_value());
  EXPECT_FALSE(value_named("", Fruit::plum).has_value());
}

}  // namespace
}  // namespace credence::internal
