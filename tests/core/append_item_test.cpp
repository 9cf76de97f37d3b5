#include "core/append_item.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace credence::internal {
namespace {

TEST(AppendItem, SeparatesAllButTheFirst) {
  std::string list;
  append_item(list, "a");
  append_item(list, "b");
  append_item(list, "c", "; ");
  EXPECT_EQ(list, "a, b; c");
}

TEST(FirstItems, CountThoseBehindThem) {
  const std::vector<std::string> items = {"a", "b", "c"};
  EXPECT_EQ(first_items(items, 3), "a, b, c");
  EXPECT_EQ(first_items(items, 2), "a, b and 1 more");
  EXPECT_EQ(first_items({}, 2), "");
}

TEST(Counted, HasAnSUnlessItIsOne) {
  EXPECT_EQ(counted(0, "run"), "0 runs");
  EXPECT_EQ(counted(1, "run"), "1 run");
  EXPECT_EQ(counted(std::size_t{2}, "run"), "2 runs");
}

TEST(Ordinal, OfTheTeensEndsInTh) {
  for (const auto& [n, text] : std::vector<std::pair<std::int64_t, std::string>>{{1, "1st"},
                                                                                 {2, "2nd"},
                                                                                 {3, "3rd"},
                                                                                 {4, "4th"},
                                                                                 {11, "11th"},
                                                                                 {12, "12th"},
                                                                                 {13, "13th"},
                                                                                 {21, "21st"},
                                                                                 {32, "32nd"},
                                                                                 {112, "112th"},
                                                                                 {512, "512th"}})
    EXPECT_EQ(ordinal(n), text);
}

}  // namespace
}  // namespace credence::internal
