#include "datasets/arrays/array_mistakes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// One run of two white states with these standard deviations, and what stands on the diagonal of P.
class TwoStates {
 public:
  TwoStates(const std::vector<double>& deviations, const std::vector<double>& diagonal) {
    std::mt19937_64 generator(3);
    std::normal_distribution<double> normal;
    for (int k = 0; k < kSteps; ++k) {
      for (const double sigma : deviations) error_.push_back(sigma * normal(generator));
    }
    P_ = {diagonal[0], 0.0, 0.0, diagonal[1]};
    arrays_.layout.states = {"a", "b"};
    arrays_.layout.angles = {false, false};
    add_named_blocks(arrays_.layout);
    ArrayRun run;
    run.steps = kSteps;
    run.error = {error_.data(), 2};
    run.P = {P_.data(), 0};
    arrays_.runs.push_back(run);
  }

  ArrayRuns& arrays() { return arrays_; }

 private:
  static constexpr int kSteps = 400;

  std::vector<double> error_, P_;
  ArrayRuns arrays_;
};

TEST(ArrayMistakes, StandardDeviationsOnTheDiagonalAreToldAndVariancesAreNot) {
  TwoStates deviations({0.1, 0.2}, {0.1, 0.2});
  EXPECT_THAT(array_mistakes(deviations.arrays()),
              ElementsAre(HasSubstr("P holds standard deviations, not variances")));
  TwoStates variances({0.1, 0.2}, {0.01, 0.04});
  EXPECT_THAT(array_mistakes(variances.arrays()), IsEmpty());
}

// A filter that is wrong by a factor is no mistake of who wrote the arrays.
TEST(ArrayMistakes, AWrongScaleIsNone) {
  TwoStates optimistic({0.1, 0.2}, {0.005, 0.02});
  EXPECT_THAT(array_mistakes(optimistic.arrays()), IsEmpty());
}

TEST(ArrayMistakes, WithoutATruthNothingIsKnown) {
  TwoStates deviations({0.1, 0.2}, {0.1, 0.2});
  deviations.arrays().layout.has_truth = false;
  EXPECT_THAT(array_mistakes(deviations.arrays()), IsEmpty());
}

TEST(ArrayMistakes, DegreesOfADeclaredAngleAreTold) {
  constexpr double kDegree = 0.017453292519943295;
  TwoStates degrees({0.1, 0.05}, {0.01, 0.0025 / (kDegree * kDegree)});
  degrees.arrays().layout.angles = {false, true};
  EXPECT_THAT(array_mistakes(degrees.arrays()), ElementsAre(HasSubstr("P is in degrees in b")));
}

}  // namespace
}  // namespace credence::internal
