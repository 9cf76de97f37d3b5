#include "datasets/logs/conventions/swapped_axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// An error of two states by run and step.
using ErrorAt = std::function<Vector(std::size_t run, std::size_t step)>;

std::string said_of(std::size_t runs, std::size_t steps, const ErrorAt& error) {
  SwappedAxes axes;
  Step step;
  step.P = Vector(Eigen::Vector2d(4.0, 0.25)).asDiagonal();
  step.states = {0, 1};
  for (std::size_t r = 0; r < runs; ++r) {
    axes.begin_run();
    for (std::size_t k = 0; k < steps; ++k) {
      step.error = Eigen::Vector2d(2.0, 0.5).cwiseProduct(error(r, k));
      axes.add(step);
    }
  }
  return axes.says();
}

/// Errors with a memory of `a` from one row to the next, `rows` of them, of each of the columns.
std::vector<std::vector<Vector>> with_memory(double a, std::size_t columns, std::size_t rows,
                                             std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vector(Eigen::Vector2d(normal(generator), normal(generator))); };
  std::vector<std::vector<Vector>> errors(columns);
  for (std::vector<Vector>& column : errors) {
    column.push_back(draw());
    while (column.size() < rows) column.push_back(a * column.back() + std::sqrt(1.0 - a * a) * draw());
  }
  return errors;
}

TEST(SwappedAxes, ErrorsWithAMemoryFromRunToRunAreToldAndThoseFromStepToStepAreNot) {
  for (const double a : {0.5, 0.8, 0.95, 0.99}) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const auto errors = with_memory(a, 40, 150, seed);  // 40 runs of 150 steps
      EXPECT_THAT(said_of(40, 150, [&](std::size_t r, std::size_t k) { return errors[r][k]; }), IsEmpty());
      EXPECT_THAT(said_of(150, 40, [&](std::size_t r, std::size_t k) { return errors[k][r]; }),
                  HasSubstr("as where (steps, runs, n) is given for (runs, steps, n)"))
          << a;
    }
  }
}

// White errors hang together neither way.
TEST(SwappedAxes, OfWhiteErrorsNothingIsKnown) {
  const auto errors = with_memory(0.0, 60, 60, 4);
  EXPECT_THAT(said_of(60, 60, [&](std::size_t r, std::size_t k) { return errors[r][k]; }), IsEmpty());
}

// All runs share an error that is another one at each step: from run to run it stays.
TEST(SwappedAxes, WhatAllRunsShareIsNoMistakeOfAxes) {
  const auto own = with_memory(0.0, 60, 60, 5), shared = with_memory(0.0, 1, 60, 6);
  EXPECT_THAT(
      said_of(60, 60, [&](std::size_t r, std::size_t k) { return Vector(own[r][k] + 3.0 * shared[0][k]); }),
      IsEmpty());
}

TEST(SwappedAxes, FewRunsOrStepsAndRunsOfOtherLengthsSayNothing) {
  const auto errors = with_memory(0.9, 40, 150, 7);
  const auto swapped = [&](std::size_t r, std::size_t k) { return errors[k][r]; };
  EXPECT_THAT(said_of(19, 40, swapped), IsEmpty());
  EXPECT_THAT(said_of(150, 19, swapped), IsEmpty());
  SwappedAxes axes;
  Step step;
  step.P = Matrix::Identity(2, 2);
  step.states = {0, 1};
  for (std::size_t r = 0; r < 150; ++r) {
    axes.begin_run();
    for (std::size_t k = 0; k < 40 - r % 2; ++k) {
      step.error = errors[k][r];
      axes.add(step);
    }
  }
  EXPECT_THAT(axes.says(), IsEmpty());
}

}  // namespace
}  // namespace credence::internal
