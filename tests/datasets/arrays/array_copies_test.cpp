#include "datasets/arrays/array_copies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

/// Runs of two white states, the last `copied` of which are the first ones with this much noise.
CopiedRuns copies_of(std::size_t runs, std::size_t copied, double noise) {
  constexpr std::size_t kSteps = 60;
  std::mt19937_64 generator(4);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> errors(runs, std::vector<double>(2 * kSteps));
  ArrayRuns arrays;
  arrays.layout.states = {"a", "b"};
  for (std::size_t r = 0; r < runs; ++r) {
    for (std::size_t i = 0; i < errors[r].size(); ++i)
      errors[r][i] =
          r < runs - copied ? normal(generator) : errors[r - (runs - copied)][i] + noise * normal(generator);
    ArrayRun run;
    run.steps = kSteps;
    run.error = {errors[r].data(), 2};
    arrays.runs.push_back(run);
  }
  return array_copies(arrays);
}

TEST(ArrayCopies, RunsWithALittleNoiseOrNoneAreFound) {
  for (const double noise : {0.0, 1e-9, 1e-3}) {
    const CopiedRuns found = copies_of(20, 10, noise);
    EXPECT_EQ(found.runs, 10) << noise;
    EXPECT_TRUE(found.many());
    EXPECT_THAT(found.says, HasSubstr("run 10 has"));
    EXPECT_THAT(found.says, HasSubstr("the errors of run 0"));
    EXPECT_THAT(found.says, HasSubstr("9 more runs"));
  }
  EXPECT_EQ(copies_of(20, 1, 1e-9).runs, 1);
  EXPECT_FALSE(copies_of(20, 1, 1e-9).many());
}

TEST(ArrayCopies, IndependentRunsAreNone) {
  EXPECT_EQ(copies_of(200, 0, 0.0).runs, 0);
  EXPECT_EQ(copies_of(20, 10, 1.0).says, "");
}

}  // namespace
}  // namespace credence::internal
