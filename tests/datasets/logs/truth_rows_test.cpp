#include "datasets/logs/truth_rows.h"

#include <gtest/gtest.h>

#include <vector>

namespace credence::internal {
namespace {

struct Fix {
  double time_s;
};

std::optional<TruthRows> at(double time_s, const TrajectoryMatching& matching) {
  return truth_rows(std::vector<Fix>{{1.0}, {2.0}, {4.0}}, time_s, matching, &Fix::time_s);
}

TEST(TruthRows, AreThoseBeforeAndBehindWithinTheLimit) {
  const TrajectoryMatching matching{.max_time_difference_s = 1.5};
  EXPECT_EQ(at(1.25, matching)->row, 0U);
  EXPECT_EQ(at(1.25, matching)->share, 0.25);
  EXPECT_EQ(at(3.0, matching)->row, 1U);
  EXPECT_EQ(at(3.0, matching)->share, 0.5);
  EXPECT_FALSE(at(2.4, matching)) << "the next row is 1.6 s away";
  EXPECT_FALSE(at(0.9, matching)) << "nothing is before";
  EXPECT_FALSE(at(4.1, matching)) << "nothing is behind";
}

TEST(TruthRows, OfTheSameTimeIsOneAlone) {
  const TrajectoryMatching matching{.max_time_difference_s = 0.0};
  for (const double off : {0.0, 0.9e-6, -0.9e-6}) {
    ASSERT_TRUE(at(2.0 + off, matching));
    EXPECT_EQ(at(2.0 + off, matching)->row, 1U);
    EXPECT_EQ(at(2.0 + off, matching)->share, 0.0);
  }
  EXPECT_EQ(at(4.0 + 0.9e-6, matching)->row, 2U);
  EXPECT_FALSE(at(2.0 + 1.1e-6, matching));
}

TEST(TruthRows, NearestIsTheEarlierOfTwoThatAreAsNear) {
  const TrajectoryMatching matching{.max_time_difference_s = 1.0, .truth_time = TruthTime::nearest};
  EXPECT_EQ(at(3.0, matching)->row, 1U);
  EXPECT_EQ(at(3.1, matching)->row, 2U);
  EXPECT_EQ(at(3.1, matching)->share, 0.0);
  EXPECT_EQ(at(4.9, matching)->row, 2U);
  EXPECT_FALSE(at(5.1, matching));
  EXPECT_FALSE(truth_rows(std::vector<double>{}, 1.0, matching));
}

}  // namespace
}  // namespace credence::internal
