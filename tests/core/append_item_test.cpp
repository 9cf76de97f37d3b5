#include "core/append_item.h"

#include <gtest/gtest.h>

#include <string>
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

}  // namespace
}  // namespace credence::internal
