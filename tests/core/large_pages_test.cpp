#include "core/large_pages.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <thread>
#include <vector>

namespace credence::internal {
namespace {

void expect_memory() {
  for (const std::size_t size : {std::size_t{100}, std::size_t{1} << 17, std::size_t{1} << 23}) {
    std::vector<double> numbers(size, 1.5);
    numbers.resize(2 * size, 2.5);
    EXPECT_EQ(numbers.front(), 1.5);
    EXPECT_EQ(numbers[size - 1], 1.5);
    EXPECT_EQ(numbers.back(), 2.5);
  }
}

TEST(LargePages, HoldWhatIsWrittenToThem) {
  use_large_pages();
  expect_memory();
  use_one_heap();
  const std::jthread other(expect_memory);
}

}  // namespace
}  // namespace credence::internal
