#include "montecarlo/engine/skewed_moments.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/analysis/laws/golden_run_averages.h"

namespace credence::internal {
namespace {

TEST(SkewedMoments, MergingIsAddingOneByOne) {
  const SkewedMoments whole = test::golden_moments(24);
  SkewedMoments first;
  SkewedMoments second;
  for (std::size_t i = 0; i < 24; ++i) (i < 7 ? first : second).add(test::kRunAverages[i]);
  first.merge(second);
  first.merge({});
  EXPECT_EQ(first.count, 24);
  EXPECT_NEAR(first.mean, whole.mean, 1e-14);
  EXPECT_NEAR(first.m2, whole.m2, 1e-12);
  EXPECT_NEAR(first.m3, whole.m3, 1e-11);

  // numpy, see golden_run_averages.h.
  EXPECT_NEAR(whole.mean, 1.09625, 1e-14);
  EXPECT_NEAR(whole.variance(), 1.2240325434782608, 1e-12);
  EXPECT_NEAR(std::sqrt(24.0) * whole.m3 / std::pow(whole.m2, 1.5), 3.895104871534343, 1e-11);
}

}  // namespace
}  // namespace credence::internal
