#include "analysis/laws/shape/vector_moments.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "tests/analysis/laws/moments_of.h"

namespace credence::internal {
namespace {

using testing::moments_of;

TEST(VectorMoments, AreMeanAndScatterByHand) {
  const VectorMoments moments = moments_of({Vector{{1.0, 10.0}}, Vector{{2.0, 40.0}}, Vector{{6.0, 10.0}}});
  EXPECT_EQ(moments.count, 3);
  EXPECT_NEAR(moments.mean[0], 3.0, 1e-15);
  EXPECT_NEAR(moments.mean[1], 20.0, 1e-14);
  EXPECT_NEAR(moments.scatter(0, 0), 4.0 + 1.0 + 9.0, 1e-14);
  EXPECT_NEAR(moments.scatter(1, 1), 100.0 + 400.0 + 100.0, 1e-12);
  EXPECT_NEAR(moments.scatter(0, 1), 20.0 - 20.0 - 30.0, 1e-13);
  EXPECT_NEAR(moments.scatter(1, 0), -30.0, 1e-13);
}

TEST(VectorMoments, KeepTheirDigitsFarFromZero) {
  const Vector far{{1e9, -1e9}};
  VectorMoments first = moments_of({far + Vector{{1.0, 2.0}}, far - Vector{{1.0, 2.0}}});
  const VectorMoments second = moments_of({far + Vector{{3.0, 0.0}}, far - Vector{{3.0, 0.0}}});
  first.merge(second);
  EXPECT_NEAR(first.scatter(0, 0), 20.0, 1e-6);
  EXPECT_NEAR(first.scatter(1, 1), 8.0, 1e-6);
  EXPECT_NEAR(first.scatter(1, 0), 4.0, 1e-6);
}

TEST(VectorMoments, MergeAsIfAddedTogether) {
  const Vector a{{1.0, 10.0}}, b{{2.0, 40.0}}, c{{6.0, 10.0}}, d{{-5.0, 3.0}};
  VectorMoments merged = moments_of({a});
  merged.merge(moments_of({b, c, d}));
  const VectorMoments together = moments_of({a, b, c, d});
  EXPECT_EQ(merged.count, 4);
  EXPECT_LT((merged.mean - together.mean).norm(), 1e-14);
  EXPECT_LT((merged.scatter - together.scatter).norm(), 1e-12);
}

TEST(VectorMoments, MergeOnlyWhatHasTheirSize) {
  VectorMoments two = moments_of({Vector{{1.0, 2.0}}});
  EXPECT_THROW(two.add(Vector::Ones(3)), std::invalid_argument);
  EXPECT_THROW(two.merge(moments_of({Vector::Ones(3)})), std::invalid_argument);
  EXPECT_EQ(two.count, 1);
  two.merge({});
  EXPECT_EQ(two.count, 1);
  VectorMoments none;
  none.merge(two);
  EXPECT_EQ(none.mean, two.mean);
}

}  // namespace
}  // namespace credence::internal
