#include "datasets/logs/log_contents.h"

#include <gtest/gtest.h>

#include <cmath>

namespace credence::internal {
namespace {

TEST(LogContents, a_rate_is_of_the_intervals_and_not_of_the_messages) {
  EXPECT_EQ(message_rate(11, 5.0, 6.0), 10.0);
  EXPECT_EQ(message_rate(2, -1.0, 1.0), 0.5);
}

TEST(LogContents, without_an_interval_there_is_no_rate) {
  EXPECT_TRUE(std::isnan(message_rate(1, 0.0, 1.0)));
  EXPECT_TRUE(std::isnan(message_rate(0, 0.0, 0.0)));
  EXPECT_TRUE(std::isnan(message_rate(5, 2.0, 2.0)));
  EXPECT_TRUE(std::isnan(message_rate(5, 2.0, 1.0)));
  EXPECT_TRUE(std::isnan(message_rate(5, 0.0, kNaN)));
}

}  // namespace
}  // namespace credence::internal
