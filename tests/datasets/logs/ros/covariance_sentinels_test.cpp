#include "datasets/logs/ros/covariance_sentinels.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "core/nan.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kSentinelInfinity = std::numeric_limits<double>::infinity();

PoseCovariance sentinel_diagonal(const std::array<double, 6>& variances) {
  PoseCovariance P = PoseCovariance::Zero();
  for (Index i = 0; i < 6; ++i) P(i, i) = variances[static_cast<std::size_t>(i)];
  return P;
}

SpatialPose sentinel_place(double x) { return {{x, 0.0, 0.0}, Eigen::Quaterniond::Identity()}; }

TEST(CovarianceSentinels, a_variance_of_zero_or_beyond_1e5_or_not_finite_is_none) {
  CovarianceSentinels sentinels;
  const auto kept = [&](const std::array<double, 6>& variances) {
    return sentinels.kept(sentinel_diagonal(variances), {});
  };
  EXPECT_THAT(kept({1e-300, 99999.999, 1e5, 0.0, -0.0, kNaN}), ElementsAre(0, 1));
  EXPECT_THAT(kept({kSentinelInfinity, -kSentinelInfinity, 1e6, 1e308, 2.0, 0.5}), ElementsAre(4, 5));
  EXPECT_THAT(kept({0, 0, 0, 0, 0, 0}), IsEmpty());
  EXPECT_THAT(kept({1, 2, 3, 4, 5, 6}), ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(CovarianceSentinels, a_negative_variance_is_kept_for_the_row_to_be_rejected) {
  CovarianceSentinels sentinels;
  EXPECT_THAT(sentinels.kept(sentinel_diagonal({1, -1, -0.5, 1, 1, 1}), {}), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(sentinels.kept(sentinel_diagonal({-0.5, 1, 1, 1, 1, 1}), {}), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(sentinels.remarks("/t"), IsEmpty());
}

TEST(CovarianceSentinels, minus_one_first_says_that_nothing_is_known) {
  CovarianceSentinels sentinels;
  EXPECT_THAT(sentinels.kept(sentinel_diagonal({-1, 1, 1, 1, 1, 1}), {}), IsEmpty());
  EXPECT_THAT(sentinels.kept(sentinel_diagonal({1, 1, 1, 1, 1, 1}), {}), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(sentinels.remarks("/t"),
              ElementsAre("/t: −1 in the first element says in 1 of 2 rows that nothing is known."));
}

TEST(CovarianceSentinels, components_are_counted_and_those_of_one_count_stand_together) {
  CovarianceSentinels sentinels;
  sentinels.kept(sentinel_diagonal({1, 0, 1e6, 0, 1, 1}), {});
  sentinels.kept(sentinel_diagonal({0, 0, kNaN, 0, 1, 1e5}), {});
  EXPECT_THAT(
      sentinels.remarks("/odom"),
      ElementsAre(HasSubstr("/odom: a variance of 0 means “not estimated”, and is left out of the dof: "
                            "y, rotation x in every row; x in 1 of 2 rows."),
                  HasSubstr("at or above 1e5 means “not estimated”, and is left out of the dof: "
                            "z, rotation z in 1 of 2 rows."),
                  HasSubstr("that is not finite means “not estimated”, and is left out of the dof: "
                            "z in 1 of 2 rows.")));
}

/// A P that is the same in every row while the body moves by `moved_m` forth and back.
CovarianceSentinels constant_rows(int rows, double moved_m, const PoseCovariance& P) {
  CovarianceSentinels sentinels;
  for (int i = 0; i < rows; ++i) sentinels.kept(P, sentinel_place(i == rows / 2 ? moved_m : 0.0));
  return sentinels;
}

TEST(CovarianceSentinels, a_constant_takes_ten_rows_and_a_tenth_of_a_metre) {
  const PoseCovariance P = sentinel_diagonal({1, 1, 1, 1, 1, 1});
  EXPECT_TRUE(constant_rows(10, 0.1, P).constant());
  EXPECT_FALSE(constant_rows(9, 5.0, P).constant());
  EXPECT_FALSE(constant_rows(50, 0.099, P).constant());
  EXPECT_FALSE(CovarianceSentinels().constant());
  EXPECT_TRUE(constant_rows(10, 1.0, sentinel_diagonal({1, 1, kNaN, 1, 1, 1})).constant())
      << "what is not a number stays what it is";
  EXPECT_THAT(constant_rows(12, 2.5, P).remarks("/t"),
              ElementsAre(HasSubstr("never changes over 12 rows while the body moves 2.5 m")));
}

TEST(CovarianceSentinels, one_entry_that_changes_in_one_row_is_no_constant) {
  for (const Index entry : {0, 7, 30, 35}) {
    CovarianceSentinels sentinels;
    PoseCovariance P = sentinel_diagonal({1, 1, 1, 1, 1, 1});
    for (int i = 0; i < 20; ++i) {
      PoseCovariance now = P;
      if (i == 11) now.data()[entry] = std::nextafter(now.data()[entry], 2.0);
      sentinels.kept(now, sentinel_place(i));
    }
    EXPECT_FALSE(sentinels.constant()) << entry;
  }
}

TEST(CovarianceSentinels, places_that_are_not_finite_are_no_movement) {
  CovarianceSentinels sentinels;
  for (int i = 0; i < 20; ++i)
    sentinels.kept(PoseCovariance::Identity(), sentinel_place(i == 5 ? kNaN : 0.0));
  EXPECT_FALSE(sentinels.constant());
}

TEST(CovarianceSentinels, planar_is_x_y_and_yaw_in_every_row_and_nothing_else_in_any) {
  const std::array<double, 6> flat = {1, 1, 0, 1e6, kNaN, 1};
  const auto planar = [&](const std::array<double, 6>& second) {
    CovarianceSentinels sentinels;
    sentinels.kept(sentinel_diagonal(flat), {});
    sentinels.kept(sentinel_diagonal(second), {});
    return sentinels.planar();
  };
  EXPECT_TRUE(planar({1, 1, 1e9, 0, 0, 1}));
  EXPECT_FALSE(planar({1, 1, 1, 0, 0, 1}));
  EXPECT_FALSE(planar({1, 0, 0, 0, 0, 1}));
  EXPECT_FALSE(planar({1, 1, 0, 0, 0, 1e5}));
  EXPECT_FALSE(planar({-1, 1, 0, 0, 0, 1}));
  EXPECT_FALSE(CovarianceSentinels().planar()) << "without rows";
}

}  // namespace
}  // namespace credence::internal
