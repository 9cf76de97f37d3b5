#include "datasets/replay/carpark_long_horizon.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <stdexcept>

#include "core/stop_point.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

ReplaySettings settings(Inflation inflation, InflationSolution solution, Index anchors = 0) {
  ReplaySettings result = carpark_settings();
  result.filter.inflation = inflation;
  result.filter.solution = solution;
  result.world.full = anchors > 0;
  result.world.anchors = anchors;
  return result;
}

/// log2 of the landmarks' trace after all loops over that after half of them: 0 flat, 1 linear growth.
double growth_exponent(const LongHorizonResult& result) {
  const std::size_t loops = result.loops.size(), half = loops / 2;
  return std::log2(result.loops.back().landmarks / result.loops[half - 1].landmarks) /
         std::log2(static_cast<double>(loops) / static_cast<double>(half));
}

// What stays bounded and what does not: the table of theory, section 5, on the geometry of the car park.
TEST(CarparkLongHorizon, PairwiseGrowsAndTheReferenceDoesNot) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const CarparkLog log = read_carpark(data);
  constexpr auto kPairwise = InflationSolution::pairwise;
  const LongHorizonPlan plan{.loops = 10, .scan_stride = 2};

  const auto none = carpark_long_horizon(log, settings(Inflation::none, kPairwise), plan);
  ASSERT_TRUE(none.ok);
  ASSERT_EQ(none.loops.size(), 10U);
  EXPECT_EQ(none.steps, 1 + 10 * 2 * 252);
  EXPECT_NEAR(growth_exponent(none), 0, 0.01);
  EXPECT_LE(none.growth_per_loop(), 1);

  const auto full = carpark_long_horizon(log, settings(Inflation::full, kPairwise), plan);
  EXPECT_GT(full.growth_per_loop(), 1.5);
  EXPECT_GT(growth_exponent(full), 3);
  EXPECT_GT(full.loops[4].landmarks, 5 * full.loops[1].landmarks);

  const auto map = carpark_long_horizon(log, settings(Inflation::map, kPairwise), plan);
  EXPECT_NEAR(growth_exponent(map), 1, 0.15);
  const double early = map.loops[5].landmarks - map.loops[4].landmarks;
  const double late = map.loops[9].landmarks - map.loops[8].landmarks;
  EXPECT_NEAR(late / early, 1, 0.02) << "the same added every loop";
}

TEST(CarparkLongHorizon, ExactMinimalTraceOfTheMapStaysAndOfAllCreeps) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const CarparkLog log = read_carpark(data);
  constexpr auto kExact = InflationSolution::min_trace;
  const auto full =
      carpark_long_horizon(log, settings(Inflation::full, kExact), {.loops = 6, .scan_stride = 5});
  EXPECT_EQ(full.not_converged, 0);
  EXPECT_GT(full.growth_per_loop(), 1.01);
  EXPECT_LT(growth_exponent(full), 1);

  const auto map =
      carpark_long_horizon(log, settings(Inflation::map, kExact), {.loops = 2, .scan_stride = 10});
  EXPECT_EQ(map.not_converged, 0);
  EXPECT_NEAR(map.growth_per_loop(), 1, 0.01);
}

TEST(CarparkLongHorizon, SequentialStaysAndTwoAnchorsConverge) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const CarparkLog log = read_carpark(data);
  const LongHorizonPlan plan{.loops = 6, .scan_stride = 5};
  const auto sequential =
      carpark_long_horizon(log, settings(Inflation::map, InflationSolution::sequential), plan);
  EXPECT_NEAR(growth_exponent(sequential), 0, 0.01);
  const auto none = carpark_long_horizon(log, settings(Inflation::none, InflationSolution::pairwise), plan);
  const auto anchored =
      carpark_long_horizon(log, settings(Inflation::none, InflationSolution::pairwise, 2), plan);
  EXPECT_LT(anchored.loops.back().landmarks, 0.1 * none.loops.back().landmarks);
}

TEST(CarparkLongHorizon, IsEndedWhereItIsStopped) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const CarparkLog log = read_carpark(data);
  const std::atomic<bool> stop = true;
  const StopScope scope(&stop);
  EXPECT_THROW(carpark_long_horizon(log, settings(Inflation::map, InflationSolution::pairwise), {}), Stopped);
}

TEST(CarparkLongHorizon, RefusesImpossiblePlans) {
  EXPECT_THROW(carpark_long_horizon({}, carpark_settings(), {.loops = 0}), std::invalid_argument);
  EXPECT_THROW(carpark_long_horizon({}, carpark_settings(), {.loops = 1, .scan_stride = 0}),
               std::invalid_argument);
}

TEST(CarparkLongHorizon, GrowthOfKnownSequences) {
  LongHorizonResult result;
  EXPECT_EQ(result.growth_per_loop(), 1);
  for (const double trace : {1.0, 2.0, 3.0, 4.0}) result.loops.push_back({0, trace});
  result.loops.push_back({0, 5});
  EXPECT_DOUBLE_EQ(result.growth_per_loop(), 1.25);
}

}  // namespace
}  // namespace credence::internal
