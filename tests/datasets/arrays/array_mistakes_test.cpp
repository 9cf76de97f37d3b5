#include "datasets/arrays/array_mistakes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
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
  EXPECT_THAT(array_mistakes(deviations.arrays()).said.misfits,
              ElementsAre(HasSubstr("P holds standard deviations, not variances")));
  TwoStates variances({0.1, 0.2}, {0.01, 0.04});
  EXPECT_THAT(array_mistakes(variances.arrays()).said.misfits, IsEmpty());
}

// A filter that is wrong by a factor is no mistake of who wrote the arrays.
TEST(ArrayMistakes, AWrongScaleIsNone) {
  TwoStates optimistic({0.1, 0.2}, {0.005, 0.02});
  const Said said = array_mistakes(optimistic.arrays()).said;
  EXPECT_THAT(said.misfits, IsEmpty());
  EXPECT_THAT(said.others, IsEmpty());
}

TEST(ArrayMistakes, WithoutATruthNothingIsKnown) {
  TwoStates deviations({0.1, 0.2}, {0.1, 0.2});
  deviations.arrays().layout.has_truth = false;
  EXPECT_THAT(array_mistakes(deviations.arrays()).said.misfits, IsEmpty());
}

TEST(ArrayMistakes, DegreesOfADeclaredAngleAreTold) {
  constexpr double kDegree = 0.017453292519943295;
  TwoStates degrees({0.1, 0.05}, {0.01, 0.0025 / (kDegree * kDegree)});
  degrees.arrays().layout.angles = {false, true};
  EXPECT_THAT(array_mistakes(degrees.arrays()).said.misfits, ElementsAre(HasSubstr("P is in degrees in b")));
}

// Of arrays alone: a list of runs has no second axis to swap.
TEST(ArrayMistakes, SwappedAxesAreToldOfArrays) {
  constexpr int kRuns = 30, kSteps = 60;
  std::mt19937_64 generator(4);
  std::normal_distribution<double> normal;
  std::vector<double> error(kRuns * kSteps);  // (steps, runs), read as kSteps runs of kRuns steps
  for (std::size_t i = 0; i < error.size(); ++i)
    error[i] = i < kRuns ? normal(generator) : 0.9 * error[i - kRuns] + std::sqrt(0.19) * normal(generator);
  const double variance = 1.0;
  ArrayRuns arrays;
  arrays.layout.states = {"a"};
  arrays.layout.angles = {false};
  add_named_blocks(arrays.layout);
  for (std::size_t r = 0; r < kSteps; ++r) {
    ArrayRun& run = arrays.runs.emplace_back();
    run.steps = kRuns;
    run.error = {error.data() + r * kRuns, 1};
    run.P = {&variance, 0};
  }
  EXPECT_THAT(array_mistakes(arrays).swapped_axes, HasSubstr("axes of the arrays look swapped"));
  arrays.indexing = ArrayIndexing::listed;
  EXPECT_THAT(array_mistakes(arrays).swapped_axes, IsEmpty());
}

}  // namespace
}  // namespace credence::internal
