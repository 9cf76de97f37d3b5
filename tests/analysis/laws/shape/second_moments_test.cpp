#include "analysis/laws/shape/second_moments.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <utility>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

// The average over `steps` of u uᵀ, u = L w, w from independent components.
template <typename Component>
Matrix run_average(const Matrix& L, int steps, Component component) {
  const Matrix u = L * Matrix::NullaryExpr(L.rows(), steps, [&] { return component(); });
  return u * u.transpose() / steps;
}

template <typename Component>
SecondMoments draw(const Matrix& L, int runs, int steps, Component component) {
  SecondMoments moments;
  for (int run = 0; run < runs; ++run) moments.add(run_average(L, steps, component));
  return moments;
}

TEST(SecondMoments, TheDirectionsHoldEveryEntry) {
  const Matrix A{{1.0, 0.2, -0.3}, {0.2, 0.8, 0.1}, {-0.3, 0.1, 1.5}};
  const Matrix B{{0.5, -0.1, 0.0}, {-0.1, 1.1, 0.4}, {0.0, 0.4, 0.9}};
  SecondMoments moments;
  SecondMoments second;
  moments.add(A);
  second.add(B);
  moments.merge(second);
  moments.merge({});
  EXPECT_EQ(moments.runs(), 2);
  EXPECT_EQ(moments.along().size(), 9U);
  EXPECT_TRUE(test_second_moments(moments, 0.95).mean.isApprox(0.5 * (A + B), 1e-14));
  EXPECT_THROW(moments.add(Matrix::Identity(2, 2)), std::invalid_argument);
  EXPECT_THROW(second.add(Matrix(3, 2)), std::invalid_argument);
  SecondMoments other;
  other.add(Matrix::Identity(2, 2));
  EXPECT_THROW(moments.merge(other), std::invalid_argument);
}

TEST(SecondMoments, KeepTheirLevelWhateverTheLaw) {
  constexpr int kStudies = 600;
  std::mt19937_64 generator(91);
  std::normal_distribution<double> normal;
  std::student_t_distribution<double> student(6.0);
  const double most = 0.05 + 5.0 * test::binomial_standard_error(0.05, kStudies);
  int gaussian = 0;
  int heavy = 0;
  for (int study = 0; study < kStudies; ++study) {
    const Matrix I = Matrix::Identity(3, 3);
    gaussian +=
        test_second_moments(draw(I, 60, 4, [&] { return normal(generator); }), 0.95).p_value.two_sided() <=
        0.1;
    heavy +=
        test_second_moments(draw(I, 60, 20, [&] { return student(generator) * std::sqrt(4.0 / 6.0); }), 0.95)
            .p_value.two_sided() <= 0.1;
  }
  // The least of both directions, adjusted for all, is ≤ 5 % iff its double is ≤ 10 %.
  EXPECT_LE(gaussian / 600.0, most);
  EXPECT_LE(heavy / 600.0, most);
  EXPECT_GE(gaussian, 3);
}

TEST(SecondMoments, KeepTheirLevelInFewRunsOfErrorsThatStay) {
  // A share of every error is constant over a run, as of a map that nothing anchors. By Student's law of M −
  // 1 dof alone 16 % of the studies reject, now 2 % (docs/statistics.md).
  constexpr int kSteps = 60;
  constexpr double kShare = 0.3;
  std::mt19937_64 generator(93);
  std::normal_distribution<double> normal;
  for (const auto& [dim, studies] : {std::pair<Index, int>{12, 300}, {24, 100}}) {
    int rejected = 0;
    for (int study = 0; study < studies; ++study) {
      SecondMoments moments;
      for (int run = 0; run < 20; ++run) {
        const Vector constant =
            Vector::NullaryExpr(dim, [&] { return std::sqrt(kShare) * normal(generator); });
        Matrix errors =
            Matrix::NullaryExpr(dim, kSteps, [&] { return std::sqrt(1.0 - kShare) * normal(generator); });
        errors.colwise() += constant;
        moments.add(errors * errors.transpose() / kSteps);
      }
      const DirectedPValues p = test_second_moments(moments, 0.95).p_value;
      rejected += std::min(p.optimistic, p.pessimistic) <= 0.05;
    }
    EXPECT_LE(static_cast<double>(rejected) / studies,
              0.05 + 5.0 * test::binomial_standard_error(0.05, studies))
        << dim << " states";
  }
}

TEST(SecondMoments, FindAMissingCorrelation) {
  // Variances right, correlation 0.4 between the components 0 and 2: NEES has the right mean.
  constexpr int kStudies = 200;
  const Matrix L = Matrix{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.4, 0.0, std::sqrt(0.84)}};
  const Matrix factors = L * L.transpose();
  const Vector eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix>(factors).eigenvalues();
  std::mt19937_64 generator(92);
  std::normal_distribution<double> normal;
  int both = 0;
  int named = 0;
  int held = 0;
  for (int study = 0; study < kStudies; ++study) {
    const SecondMomentTest test =
        test_second_moments(draw(L, 100, 10, [&] { return normal(generator); }), 0.95);
    both += test.p_value.optimistic <= 0.05 && test.p_value.pessimistic <= 0.05;
    named += test.worst_direction.p == 2 && test.worst_direction.q == 0 && test.worst_direction.sign != 0;
    held += test.least_factor <= eigenvalues[0] && test.largest_factor >= eigenvalues[2];
    EXPECT_LT(test.largest_factor, 4.0);
  }
  EXPECT_GE(both, 190);
  EXPECT_GE(named, 195);
  EXPECT_GE(held / 200.0, 0.95 - 5.0 * test::binomial_standard_error(0.95, kStudies));
}

// Component 2 has nine times its variance, 0 hardly any: the least p-value is of one of them, and each side
// has its own direction.
TEST(SecondMoments, EachSideHasItsDirection) {
  std::mt19937_64 generator(94);
  std::normal_distribution<double> normal;
  const Matrix L = Vector{{0.01, 1.0, 3.0}}.asDiagonal();
  const SecondMomentTest test = test_second_moments(draw(L, 60, 20, [&] { return normal(generator); }), 0.95);
  const auto is_of = [](const SecondMomentDirection& d, Index component) {
    return d.sign == 0 && d.p == component;
  };
  EXPECT_TRUE(is_of(test.most_optimistic, 2));
  EXPECT_TRUE(is_of(test.most_pessimistic, 0));
  EXPECT_GE(test.least_factor, 0.0);
  EXPECT_LE(test.least_factor, 1e-4);
}

TEST(SecondMoments, NoTest) {
  EXPECT_EQ(test_second_moments({}, 0.95).reason, "no runs");
  SecondMoments negative;
  negative.add(Matrix{{-1.0}});
  EXPECT_FALSE(test_second_moments(negative, 0.95).reason.empty());
  EXPECT_TRUE(std::isnan(test_second_moments(negative, 0.95).p_value.optimistic));
  EXPECT_THROW(test_second_moments(negative, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
