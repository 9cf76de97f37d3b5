#pragma once

#include <random>
#include <vector>

#include "analysis/tuning/linear_score.h"
#include "core/linear_algebra/psd_root.h"

/// @file
/// Linear models and records of them for the tests of tuning.

namespace credence::internal::testing {

/// x⁺ = x + v, z = x + w, from a known start.
inline LinearModel local_level(double q, double r) {
  LinearModel model;
  const Matrix one = Matrix::Identity(1, 1);
  model.F = model.G = model.H = one;
  model.Q = q * one;
  model.R = r * one;
  model.P0 = one;
  model.layout = {.vehicle = 1, .landmark = 0, .landmarks = 0};
  return model;
}

/// F = [.9 0; −.3 .8], H = I, Q = [2 −.5; −.5 1], R = diag(3, 2): the example on which eleven methods were
/// compared [Dunik 2017].
inline LinearModel survey_model() {
  LinearModel model;
  model.F = Matrix(2, 2);
  model.F << 0.9, 0.0, -0.3, 0.8;
  model.G = model.H = Matrix::Identity(2, 2);
  model.Q = Matrix(2, 2);
  model.Q << 2.0, -0.5, -0.5, 1.0;
  model.R = Matrix(2, 2);
  model.R << 3.0, 0.0, 0.0, 2.0;
  model.P0 = 4.0 * Matrix::Identity(2, 2);
  model.layout = {.vehicle = 2, .landmark = 0, .landmarks = 0};
  return model;
}

/// Runs of the model, from x̂_0 = 0.
inline std::vector<MeasuredRun> simulate(const LinearModel& model, Index runs, Index steps,
                                         std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](const Matrix& root) -> Vector {
    Vector v(root.cols());
    for (double& x : v) x = normal(random);
    return root * v;
  };
  const Matrix initial = psd_root(model.P0), process = model.G * psd_root(model.Q),
               measurement = psd_root(model.R);
  std::vector<MeasuredRun> all;
  for (Index i = 0; i < runs; ++i) {
    MeasuredRun& run = all.emplace_back();
    run.start = Vector::Zero(model.state_dim());
    run.z.resize(model.measurement_dim(), steps);
    Vector x = draw(initial);
    for (Index k = 0; k < steps; ++k) {
      x = model.F * x + draw(process);
      run.z.col(k) = model.H * x + draw(measurement);
    }
  }
  return all;
}

}  // namespace credence::internal::testing
