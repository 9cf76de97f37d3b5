#include "montecarlo/random/noise_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "montecarlo/random/noise.h"

namespace credence::internal {
namespace {

constexpr NoiseShape kAll{.correlation = 0.8, .student_dof = 5, .outlier_rate = 0.1, .outlier_scale = 4.0};

NoiseSource shaped_source(const NoiseShape& measurement) { return NoiseSource(1, 0).shaped({}, measurement); }

/// numbers[run][step − 1] of slot 0, purpose measurement.
std::vector<std::vector<double>> sequences(const NoiseSource& source, std::int64_t runs, std::int64_t steps) {
  std::vector<std::vector<double>> numbers;
  for (std::int64_t run = 0; run < runs; ++run) {
    std::vector<double>& of_run = numbers.emplace_back();
    for (std::int64_t k = 1; k <= steps; k += 4) {
      std::vector<double> four(4);
      source.normals_of_four_steps(run, k, NoisePurpose::measurement, 1, four);
      of_run.insert(of_run.end(), four.begin(), four.end());
    }
  }
  return numbers;
}

// Three ways to the same number: the promise of same bits rests on it.
TEST(NoiseShape, EveryWayGivesTheSameNumber) {
  const NoiseSource source = shaped_source(kAll);
  constexpr std::int64_t kSlots = 3, kSteps = 8, kFirst = 13;
  std::vector<double> lanes(kSlots * kSteps * NoiseSource::kLanes), four(4 * kSlots), one(2);
  source.normals_of_runs(7, kFirst, kSteps, NoisePurpose::measurement, kSlots, lanes);
  for (std::int64_t run = 7; run < 7 + NoiseSource::kLanes; ++run) {
    for (std::int64_t k = 0; k < kSteps; ++k) {
      if (k % 4 == 0) {
        source.normals_of_four_steps(run, kFirst + k, NoisePurpose::measurement, kSlots, four);
      }
      source.normals(run, kFirst + k, NoisePurpose::measurement, one, 1);
      for (std::int64_t slot = 0; slot < kSlots; ++slot) {
        const double value = four[static_cast<std::size_t>(k % 4 * kSlots + slot)];
        EXPECT_EQ(lanes[static_cast<std::size_t>((slot * kSteps + k) * NoiseSource::kLanes + run - 7)],
                  value);
        if (slot > 0) {
          EXPECT_EQ(one[static_cast<std::size_t>(slot - 1)], value);
        }
      }
    }
  }
}

TEST(NoiseShape, APlainShapeChangesNothingAndAnotherPurposeIsLeftAlone) {
  const NoiseSource plain(1, 0), none = plain.shaped({}, {}), all = shaped_source(kAll);
  for (const NoisePurpose purpose : {NoisePurpose::initial, NoisePurpose::process, NoisePurpose::world}) {
    EXPECT_EQ(all.normal(3, 5, purpose, 2), plain.normal(3, 5, purpose, 2));
  }
  EXPECT_EQ(none.normal(3, 5, NoisePurpose::measurement, 2),
            plain.normal(3, 5, NoisePurpose::measurement, 2));
  EXPECT_NE(all.normal(3, 5, NoisePurpose::measurement, 2), plain.normal(3, 5, NoisePurpose::measurement, 2));
  EXPECT_NE(plain.shaped(kAll, {}).normal(3, 5, NoisePurpose::process, 2),
            all.normal(3, 5, NoisePurpose::measurement, 2));
}

// E[n_j n_k] = ρ^|j−k|, across the ends of the intervals of bisection (64 steps here) as within them. Of R
// independent runs the mean product has the standard error √((1 + ρ²)/R) at most.
TEST(NoiseShape, CorrelationIsThatOfAGaussMarkovSequence) {
  constexpr double kRho = 0.5, kErrors = 5.0;
  constexpr std::int64_t kRuns = 20'000, kSteps = 132;
  const auto numbers = sequences(shaped_source({.correlation = kRho}), kRuns, kSteps);
  const double error = kErrors * std::sqrt(2.0 / kRuns);
  for (const std::size_t j : {0U, 2U, 20U, 61U, 62U, 63U, 64U, 125U, 127U}) {
    for (const std::size_t lag : {0U, 1U, 2U, 3U, 4U}) {
      double sum = 0.0;
      for (const auto& run : numbers) sum += run[j] * run[j + lag];
      EXPECT_NEAR(sum / kRuns, std::pow(kRho, lag), error) << "step " << j + 1 << ", lag " << lag;
    }
  }
}

// Var = 1; E[x⁴] = 3 (ν − 2)/(ν − 4) = 4 at ν = 10, where E[x⁸] is finite.
TEST(NoiseShape, StudentsTailsHaveItsMoments) {
  constexpr std::int64_t kRuns = 4000, kSteps = 100;
  const auto numbers = sequences(shaped_source({.student_dof = 10}), kRuns, kSteps);
  double second = 0.0, fourth = 0.0, eighth = 0.0;
  for (const auto& run : numbers) {
    for (const double x : run) {
      second += x * x;
      fourth += std::pow(x, 4);
      eighth += std::pow(x, 8);
    }
  }
  constexpr double kNumbers = kRuns * kSteps, kErrors = 5.0;
  second /= kNumbers;
  fourth /= kNumbers;
  eighth /= kNumbers;
  EXPECT_NEAR(second, 1.0, kErrors * std::sqrt(3.0 / kNumbers));
  EXPECT_NEAR(fourth, 4.0, kErrors * std::sqrt(eighth / kNumbers));
}

// Of N(0, 1) the share beyond 5 is 5.7e-7; an outlier of scale 4 is there with probability 0.2113.
TEST(NoiseShape, OutliersComeAtTheirRate) {
  constexpr std::int64_t kRuns = 1000, kSteps = 100;
  const auto numbers = sequences(shaped_source({.outlier_rate = 0.1, .outlier_scale = 4.0}), kRuns, kSteps);
  double beyond = 0.0, squares = 0.0;
  for (const auto& run : numbers) {
    for (const double x : run) {
      beyond += std::abs(x) > 5.0 ? 1.0 : 0.0;
      squares += x * x;
    }
  }
  constexpr double kNumbers = kRuns * kSteps, kErrors = 5.0;
  const double share = 0.1 * std::erfc(5.0 / 4.0 / std::sqrt(2.0)) + 0.9 * std::erfc(5.0 / std::sqrt(2.0));
  EXPECT_NEAR(beyond / kNumbers, share, kErrors * std::sqrt(share / kNumbers));
  EXPECT_NEAR(squares / kNumbers, 1.0 + 0.1 * 15.0, kErrors * std::sqrt(0.1 * 3.0 * 256.0 / kNumbers));
}

TEST(NoiseShape, RefusesWhatCannotBe) {
  for (const NoiseShape shape :
       {NoiseShape{.correlation = 1.0}, NoiseShape{.correlation = -0.1}, NoiseShape{.student_dof = 2},
        NoiseShape{.outlier_rate = 1.5}, NoiseShape{.outlier_scale = -1.0}}) {
    EXPECT_THROW(shaped_source(shape), std::invalid_argument);
  }
}

}  // namespace
}  // namespace credence::internal
