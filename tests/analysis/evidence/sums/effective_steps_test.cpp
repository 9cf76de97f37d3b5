#include "analysis/evidence/sums/effective_steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "analysis/laws/mean/effective_sample.h"

namespace credence::internal {
namespace {

TEST(EffectiveSteps, OfFourRunsByHand) {
  // Variances of the steps 0.5, 4.5 and 2, of the sums 18.
  const std::vector<std::vector<double>> runs{{1.0, 2.0, 0.0}, {2.0, 5.0, 2.0}};
  EXPECT_NEAR(measured_effective_steps(runs), 3.0 * 7.0 / 18.0, 1e-15);
}

TEST(EffectiveSteps, AgreeWithTheExactLaw) {
  constexpr double kMemory = 0.9;
  constexpr std::size_t kLength = 10, kRuns = 20000;
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> runs(kRuns, std::vector<double>(kLength));
  for (std::vector<double>& run : runs) {
    double a = normal(generator), b = normal(generator);
    for (double& nees : run) {
      nees = a * a + b * b;
      a = kMemory * a + std::sqrt(1.0 - kMemory * kMemory) * normal(generator);
      b = kMemory * b + std::sqrt(1.0 - kMemory * kMemory) * normal(generator);
    }
  }
  const std::vector<Matrix> transitions(kLength, kMemory * Matrix::Identity(2, 2));
  const std::vector<Matrix> covariances(kLength, Matrix::Identity(2, 2));
  // The variance of a variance of sums with this tail: √(4/20000), and five of them.
  EXPECT_NEAR(measured_effective_steps(runs) / linear_run_law(transitions, covariances).effective_steps, 1.0,
              0.07);
}

TEST(EffectiveSteps, RunsAreOfOneLength) {
  std::vector<std::vector<double>> runs{{1.0, 2.0}, {2.0, 1.5}};
  EXPECT_THROW(measured_effective_steps(std::span(runs).first(1)), std::invalid_argument);
  runs[1].pop_back();
  EXPECT_THROW(measured_effective_steps(runs), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
