#include "core/memory_need.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace credence::internal {
namespace {

TEST(MemoryNeed, RefusesMoreThanThereIsAndNothingElse) {
  EXPECT_GT(memory_limit(), 1e7);
  EXPECT_NO_THROW(require_memory(memory_limit(), "x = 1"));
  try {
    require_memory(8e18, "x = 1000");
    FAIL() << "eight exabytes";
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what()).find("x = 1000: needs at least 8e+09 GB of memory"), 0U)
        << error.what();
  }
}

}  // namespace
}  // namespace credence::internal
