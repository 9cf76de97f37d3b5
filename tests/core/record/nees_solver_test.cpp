#include "core/record/nees_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/nan.h"
#include "tests/core/record/judged_error.h"

namespace credence::internal {
namespace {

// From 32 states on another factorisation is used.
TEST(NeesSolver, is_the_dense_solution_of_every_size) {
  NeesSolver solver;
  for (const Index n : {1, 2, 3, 7, 31, 32, 33, 40, 64, 71, 5}) {
    const JudgedError j(n);
    const NeesValue nees = solver.solve(j.e, j.P);
    const double expected = square_by_lu(j.e, j.P);
    EXPECT_EQ(nees.dof, n);
    EXPECT_NEAR(nees.value, expected, 1e-9 * expected) << n;
    const Matrix L = j.P.llt().matrixL();
    const Vector whitened = L.triangularView<Eigen::Lower>().solve(j.e);
    EXPECT_LT((solver.whitened() - whitened).cwiseAbs().maxCoeff(), 1e-9 * whitened.norm()) << n;
    for (Index i = 0; i < n; ++i) EXPECT_NEAR(solver.pivot(i), L(i, i), 1e-10 * L(i, i)) << n;
    EXPECT_NEAR(solver.log_determinant(), 2.0 * L.diagonal().array().log().sum(), 1e-9) << n;
    const Matrix inverse = inverse_by_lu(j.P);
    for (Index i = 0; i < n; ++i) {
      EXPECT_NEAR(solver.inverse_diagonal()[i], inverse(i, i), 1e-8 * inverse(i, i)) << n << ' ' << i;
    }
  }
}

TEST(NeesSolver, reads_the_lower_triangle_alone) {
  for (const Index n : {6, 45}) {
    const JudgedError j(n);
    NeesSolver solver;
    const double value = solver.solve(j.e, j.P).value;
    Matrix lower = j.P;
    lower.triangularView<Eigen::StrictlyUpper>().setConstant(1e9);
    EXPECT_EQ(solver.solve(j.e, lower).value, value) << n;
  }
}

TEST(NeesSolver, leaves_out_states_without_variance) {
  for (const Index n : {6, 45}) {
    JudgedError j(n);
    const std::vector<Index> certain = {0, 3, n - 1};
    std::vector<Index> others;
    for (Index i = 0; i < n; ++i) {
      if (std::ranges::find(certain, i) == certain.end()) others.push_back(i);
    }
    for (const Index i : certain) {
      j.P.row(i).setZero();
      j.P.col(i).setZero();
      j.e[i] = 7.0;
    }
    NeesSolver solver;
    const NeesValue nees = solver.solve(j.e, j.P);
    const double expected = square_by_lu(j.e(others), j.P(others, others));
    EXPECT_EQ(nees.dof, n - 3);
    EXPECT_NEAR(nees.value, expected, 1e-9 * expected);
    EXPECT_EQ(solver.whitened().size(), n - 3);
    EXPECT_FALSE(solver.well_conditioned(j.P)) << "some states have no pivot";
    EXPECT_EQ(solver.solve(j.e, Matrix::Zero(n, n)).dof, 0);
  }
}

TEST(NeesSolver, knows_no_value_of_what_is_no_covariance) {
  for (const Index n : {4, 45}) {
    const JudgedError j(n);
    NeesSolver solver;
    Matrix negative = j.P;
    negative(2, 2) = -negative(2, 2);
    EXPECT_EQ(solver.solve(j.e, negative).dof, -1);
    Matrix indefinite = j.P;
    indefinite(2, 1) = indefinite(1, 2) = 2.0 * std::sqrt(j.P(1, 1) * j.P(2, 2));
    EXPECT_EQ(solver.solve(j.e, indefinite).dof, -1);
    for (const double value : {kNaN, std::numeric_limits<double>::infinity()}) {
      Matrix infinite = j.P;
      infinite(2, 2) = value;
      EXPECT_EQ(solver.solve(j.e, infinite).dof, -1) << n << " states, a variance of " << value;
      infinite = j.P;
      infinite(2, 1) = infinite(1, 2) = value;
      EXPECT_EQ(solver.solve(j.e, infinite).dof, -1) << n << " states, a covariance of " << value;
    }
    Vector e = j.e;
    e[1] = kNaN;
    EXPECT_EQ(solver.solve(e, j.P).dof, -1);
    EXPECT_EQ(solver.solve(j.e, j.P).dof, n) << "the next one is as if there had been none before";
  }
}

// What is left of the state by itself: that of the tail of e and the tail's own block of P.
TEST(NeesSolver, without_the_lead_it_is_that_of_the_other_states_alone) {
  for (const Index n : {4, 9, 31, 32, 45, 61}) {
    for (const Index lead : {1, 3}) {
      const JudgedError j(n, 4);
      NeesSolver solver;
      solver.keep_lead(lead);
      solver.solve(j.e, j.P);
      const double expected = square_by_lu(j.e.tail(n - lead), j.P.bottomRightCorner(n - lead, n - lead));
      EXPECT_NEAR(solver.without_lead(), expected, 1e-8 * expected) << n << ' ' << lead;
    }
  }
}

TEST(NeesSolver, the_share_of_noise_is_that_of_its_trace) {
  for (const Index m : {2, 8, 40}) {
    const JudgedError j(m, 7);
    NeesSolver solver;
    solver.solve(j.e, j.P);
    Matrix R = Matrix::Zero(m, m);
    for (Index i = 0; i < m; ++i) R(i, i) = i % 2 == 0 ? 0.3 : 0.02;
    const double expected = (inverse_by_lu(j.P) * R).trace() / static_cast<double>(m);
    EXPECT_NEAR(solver.noise_share({0.3, 0.02}), expected, 1e-8 * expected);
  }
  NeesSolver solver;
  solver.solve(Eigen::Vector4d::Ones(), Eigen::Vector4d(1, 2, 1, 2).asDiagonal().toDenseMatrix());
  EXPECT_DOUBLE_EQ(solver.noise_share({1.0, 2.0}), 1.0) << "S is R";
}

// A squared pivot of the last state is 1 − ρ² of its variance; 400 ε is the least of four states.
TEST(NeesSolver, tells_pivots_that_rounding_has_eaten) {
  EXPECT_DOUBLE_EQ(NeesSolver::least_pivot(4), 400.0 * std::numeric_limits<double>::epsilon());
  for (const auto& [rest, well] : {std::pair{1e-12, true}, std::pair{1e-14, false}}) {
    Matrix P = Matrix::Identity(4, 4);
    P(3, 0) = P(0, 3) = std::sqrt(1.0 - rest);
    NeesSolver solver;
    ASSERT_EQ(solver.solve(Vector::Zero(4), P).dof, 4);
    EXPECT_EQ(solver.well_conditioned(P), well) << rest;
    const Vector scale = Eigen::Vector4d(1e-6, 1.0, 1e3, 1e5);
    const Matrix scaled = scale.asDiagonal() * P * scale.asDiagonal();
    ASSERT_EQ(solver.solve(Vector::Zero(4), scaled).dof, 4);
    EXPECT_EQ(solver.well_conditioned(scaled), well) << "whatever the units";
  }
}

}  // namespace
}  // namespace credence::internal
