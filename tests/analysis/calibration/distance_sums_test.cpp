#include "analysis/calibration/distance_sums.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace credence::internal {
namespace {

constexpr double kShortest_m = 1.0 / 1024.0;

TEST(DistanceSums, PutEachRowWhereItsDistanceLies) {
  DistanceSums sums;
  for (int i = 0; i < 16; ++i) {
    sums.add(kShortest_m * i, {.rows = 1, .nees = 1.0 + i, .squared = 2.0, .variance = 3.0});
    sums.add(kShortest_m * (i + 0.999), {.rows = 1});
  }
  EXPECT_EQ(sums.length_m(), kShortest_m);
  ASSERT_EQ(sums.bins().size(), DistanceSums::kMost);
  for (std::size_t i = 0; i < 16; ++i) {
    const DistanceSums::Bin& bin = sums.bins()[i];
    EXPECT_EQ(bin.rows, 2);
    EXPECT_EQ(bin.nees, 1.0 + static_cast<double>(i));
    EXPECT_EQ(bin.squared, 2.0);
    EXPECT_EQ(bin.variance, 3.0);
  }
}

TEST(DistanceSums, JoinNeighboursOnceTheWayIsLonger) {
  DistanceSums sums;
  for (int i = 0; i < 16; ++i) sums.add(kShortest_m * i, {.rows = 1, .nees = std::exp2(i)});
  sums.add(16.0 * kShortest_m, {.rows = 1});
  EXPECT_EQ(sums.length_m(), 2.0 * kShortest_m);
  ASSERT_EQ(sums.bins().size(), 9U);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(sums.bins()[i].rows, 2);
    EXPECT_EQ(sums.bins()[i].nees, 3.0 * std::exp2(2.0 * static_cast<double>(i)));
  }
  EXPECT_EQ(sums.bins()[8].rows, 1);
}

TEST(DistanceSums, DoNotDependOnTheOrderOfTheRows) {
  std::mt19937_64 generator(4);
  std::uniform_real_distribution<double> exponent(-6.0, 6.0);
  DistanceSums forth, back;
  std::vector<double> distances(300);
  for (double& d : distances) d = std::pow(10.0, exponent(generator));
  for (std::size_t i = 0; i < distances.size(); ++i) {
    forth.add(distances[i], {.rows = 1});
    back.add(distances[distances.size() - 1 - i], {.rows = 1});
  }
  EXPECT_EQ(forth.length_m(), back.length_m());
  ASSERT_EQ(forth.bins().size(), back.bins().size());
  EXPECT_LE(forth.bins().size(), DistanceSums::kMost);
  std::int64_t rows = 0;
  for (std::size_t i = 0; i < forth.bins().size(); ++i) {
    EXPECT_EQ(forth.bins()[i].rows, back.bins()[i].rows);
    rows += forth.bins()[i].rows;
    std::int64_t within = 0;
    for (const double d : distances) within += std::floor(d / forth.length_m()) == static_cast<double>(i);
    EXPECT_EQ(forth.bins()[i].rows, within);
  }
  EXPECT_EQ(rows, 300);
}

TEST(DistanceSums, LeaveOutWhatIsNoDistance) {
  DistanceSums sums;
  for (const double bad : {-1e-9, std::nan(""), HUGE_VAL, -HUGE_VAL}) sums.add(bad, {.rows = 1});
  EXPECT_TRUE(sums.bins().empty());
  EXPECT_EQ(sums.length_m(), kShortest_m);
  sums.add(4e7, {.rows = 1});  // round the earth
  EXPECT_EQ(sums.bins().back().rows, 1);
}

TEST(DistanceSums, WidenToTheLengthOfAnother) {
  DistanceSums one, other;
  one.add(0.1, {.rows = 3});
  other.add(1000.0, {.rows = 1});
  one.widen(other.length_m());
  EXPECT_EQ(one.length_m(), other.length_m());
  ASSERT_EQ(one.bins().size(), 1U);
  EXPECT_EQ(one.bins()[0].rows, 3);
  one.widen(kShortest_m);
  EXPECT_EQ(one.length_m(), other.length_m()) << "never narrower";
}

}  // namespace
}  // namespace credence::internal
