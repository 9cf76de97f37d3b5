#include "core/names_in.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace credence::internal {
namespace {

struct NamedItem {
  std::string name;
  int value = 0;
};

TEST(NamesIn, AreInTheOrderOfTheItems) {
  const std::vector<NamedItem> items = {{"b", 1}, {"", 2}, {"a", 3}};
  EXPECT_EQ(names_in(items), (std::vector<std::string_view>{"b", "", "a"}));
  EXPECT_TRUE(names_in(std::vector<NamedItem>{}).empty());
}

}  // namespace
}  // namespace credence::internal
