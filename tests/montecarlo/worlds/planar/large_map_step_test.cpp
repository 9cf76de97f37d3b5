// A step of the dense filter. Here because this is where allocations are counted.

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "core/filters/ekf_slam.h"
#include "core/manifold/angle.h"
#include "tests/montecarlo/engine/allocation_count.h"

namespace credence::internal {
namespace {

TEST(LargeMapStepAllocates, NothingOnceTheMapIsKnown) {
  constexpr int kLandmarks = 30, kMost = 7;
  const Eigen::Matrix2d noise = Eigen::Vector2d(0.01, 0.0003).asDiagonal();
  EkfSlam<PlanarModel> filter({.vehicle = {}, .dt_s = 0.1}, noise, noise);
  filter.reset(Pose::Zero(), 0.01 * Eigen::Matrix3d::Identity());
  std::vector<Observation<PlanarModel>> z;
  for (int i = 0; i < kLandmarks; ++i) z.push_back({i, {5.0 + i, wrap_angle(0.4 * i)}});
  const std::int64_t before_map = allocations_of_this_thread();
  ASSERT_EQ(filter.update(z).initialised, kLandmarks);
  EXPECT_GT(allocations_of_this_thread(), before_map);
  std::int64_t before = 0;
  for (int k = 0; k < 300; ++k) {
    // By then the most that is ever seen has been.
    if (k == 100) before = allocations_of_this_thread();
    const auto count = static_cast<std::size_t>(1 + k % kMost);
    filter.predict({0.0, 0.0});
    ASSERT_TRUE(filter.update(std::span(z).subspan(static_cast<std::size_t>(k % 23), count)).ok);
  }
  EXPECT_EQ(allocations_of_this_thread() - before, 0);
}

}  // namespace
}  // namespace credence::internal
