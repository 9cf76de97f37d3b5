#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "analysis/stability/riccati_doubling.h"
#include "core/models/linear_model.h"
#include "tests/paths.h"

namespace credence::internal::testing {

inline Matrix random_matrix(Index rows, Index cols, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  Matrix M(rows, cols);
  for (Index i = 0; i < M.size(); ++i) M.data()[i] = normal(generator);
  return M;
}

/// Symmetric psd of the given rank.
inline Matrix random_psd(Index n, Index rank, std::mt19937_64& generator) {
  const Matrix G = random_matrix(n, rank, generator);
  return G * G.transpose();
}

/// The monobot as a Riccati problem, with a constant ΔP added.
inline RiccatiProblem riccati_problem(const LinearModel& model) {
  return {model.F, model.H, model.G * model.Q * model.G.transpose(), model.R};
}

inline Matrix matrix_1x1(double value) { return Matrix::Constant(1, 1, value); }

inline RiccatiProblem scalar_problem(double f, double h, double q, double r = 1.0) {
  return {matrix_1x1(f), matrix_1x1(h), matrix_1x1(q), matrix_1x1(r)};
}

/// ‖one plain step from P, minus P‖ / ‖P‖: the residual in the caller's own units.
inline double plain_residual(const RiccatiProblem& problem, const Matrix& P) {
  const double defect = (riccati_step(problem, P) - P).norm();
  return P.norm() > 0.0 ? defect / P.norm() : defect;
}

/// Plain iteration: `steps` steps from P.
inline Matrix iterated(const RiccatiProblem& problem, Matrix P, int steps) {
  for (int k = 0; k < steps; ++k) P = riccati_step(problem, P);
  return P;
}

/// A problem of tests/analysis/stability/golden: "n p", then A, C, Q, R, row-major.
inline RiccatiProblem read_golden_problem(const std::string& name) {
  const std::filesystem::path file = source_folder() / "tests/analysis/stability/golden" / name;
  std::ifstream in(file);
  Index n = 0, p = 0;
  in >> n >> p;
  const auto read = [&in](Index rows, Index cols) {
    Matrix M(rows, cols);
    for (Index i = 0; i < rows; ++i) {
      for (Index j = 0; j < cols; ++j) in >> M(i, j);
    }
    return M;
  };
  RiccatiProblem problem;
  problem.F = read(n, n);
  problem.H = read(p, n);
  problem.Qt = read(n, n);
  problem.R = read(p, p);
  EXPECT_TRUE(in) << "cannot read " << file;
  return problem;
}

}  // namespace credence::internal::testing
