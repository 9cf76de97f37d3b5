#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/filters/linear_filter.h"
#include "core/linear_algebra/psd_root.h"
#include "montecarlo/lanes/linear_kernel.h"

/// @file
/// Error dynamics for the tests of the lanes: of filters in a linear world, and of none.

namespace credence::internal {

inline LinearErrorSystem linear_error_system(const LinearModel& truth, const LinearModel& assumed,
                                             Inflation inflation, Index steps) {
  LinearErrorSystem system{{.F = truth.F,
                            .noise_input = truth.G * psd_root(truth.Q),
                            .H = truth.H,
                            .measurement_root = psd_root(truth.R)},
                           psd_root(truth.P0),
                           {},
                           {}};
  for (const LinearFilterStep& step :
       linear_filter_steps(assumed, {.inflation = inflation, .constant = {}}, steps)) {
    EXPECT_TRUE(step.ok);
    system.steps.push_back({.K = step.K,
                            .innovation_whitening = psd_whitening(step.S),
                            .error_whitening = psd_whitening(step.P)});
  }
  return system;
}

inline LinearErrorSystem monobot_system(Index landmarks, Index anchors, Inflation inflation, Index steps) {
  const LinearModel model = monobot_model(landmarks, anchors, 0.1, 0.1, 1.0);
  return linear_error_system(model, model, inflation, steps);
}

inline Matrix uniform_matrix(Index rows, Index columns, std::mt19937_64& generator) {
  Matrix matrix(rows, columns);
  for (Index i = 0; i < matrix.size(); ++i) {
    matrix.data()[i] = std::ldexp(static_cast<double>(generator() >> 11), -52) - 1.0;
  }
  return matrix;
}

/// A system without any structure: F dense, two process noises, whitenings that are neither square nor
/// triangular.
inline LinearErrorSystem unstructured_system(Index n, Index m, Index steps) {
  std::mt19937_64 generator(7);
  LinearErrorSystem system{{.F = 0.3 * uniform_matrix(n, n, generator),
                            .noise_input = uniform_matrix(n, 2, generator),
                            .H = uniform_matrix(m, n, generator),
                            .measurement_root = uniform_matrix(m, m, generator)},
                           uniform_matrix(n, n, generator),
                           {},
                           {}};
  for (Index k = 0; k < steps; ++k) {
    system.steps.push_back({.K = 0.3 * uniform_matrix(n, m, generator),
                            .innovation_whitening = uniform_matrix(std::max<Index>(1, m - 1), m, generator),
                            .error_whitening = uniform_matrix(n - 1, n, generator)});
    // zeros at the ends of rows, and a row of nothing but zeros
    system.steps.back().error_whitening.row(0).head(n / 2).setZero();
    if (k % 3 == 1) system.steps.back().error_whitening.row(n - 2).setZero();
    if (k % 4 == 2) system.steps.back().K.row(n - 1).setZero();
  }
  return system;
}

}  // namespace credence::internal
