#include "montecarlo/random/step_draws.h"

#include <gtest/gtest.h>

#include <vector>

namespace credence::internal {
namespace {

constexpr NoisePurpose kPurpose = NoisePurpose::measurement;

TEST(StepDraws, AreTheNumbersOfTheSource) {
  const NoiseSource source(3, 1);
  StepDraws normals = StepDraws::normals(source, kPurpose, 3);
  StepDraws events = StepDraws::events(source, kPurpose, 0.3, 3);
  for (const std::int64_t run : {5, 6}) {
    normals.start(run);
    events.start(run);
    for (const Index k : {1, 2, 4, 5, 9, 2}) {  // back as well
      std::vector<double> of_step(3), of_four(12);
      source.normals(run, k, kPurpose, of_step);
      const Index first = k - (k - 1) % 4;
      source.events_of_four_steps(run, first, kPurpose, 0.3, 3, of_four);
      const double *n = normals.at(k), *e = events.at(k);
      for (std::size_t slot = 0; slot < 3; ++slot) {
        EXPECT_EQ(n[slot], of_step[slot]) << run << ' ' << k;
        EXPECT_EQ(e[slot], of_four[static_cast<std::size_t>(3 * (k - first)) + slot]) << run << ' ' << k;
      }
    }
  }
}

TEST(StepDraws, OfAnotherRunAreOthersAtTheSameStep) {
  StepDraws draws = StepDraws::normals(NoiseSource(3, 1), kPurpose, 1);
  draws.start(5);
  const double first = *draws.at(1);
  draws.start(6);
  EXPECT_NE(*draws.at(1), first);
  draws.start(5);
  EXPECT_EQ(*draws.at(1), first);
}

TEST(StepDraws, WithoutASourceNothingDisturbsAndEverythingHappens) {
  StepDraws normals = StepDraws::normals(std::nullopt, kPurpose, 2);
  StepDraws events = StepDraws::events(std::nullopt, kPurpose, 0.1, 2);
  StepDraws certain = StepDraws::events(NoiseSource(3, 1), kPurpose, 1.0, 2);
  for (Index k = 1; k < 10; ++k) {
    for (int slot = 0; slot < 2; ++slot) {
      EXPECT_EQ(normals.at(k)[slot], 0.0);
      EXPECT_EQ(events.at(k)[slot], 1.0);
      EXPECT_EQ(certain.at(k)[slot], 1.0);
    }
  }
}

}  // namespace
}  // namespace credence::internal
