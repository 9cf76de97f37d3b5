#include "analysis/laws/wishart_roots.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>
#include <stdexcept>

#include "analysis/laws/chi_square.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(WishartRoots, QuantilesInvertThePValues) {
  for (const Index n : {1, 2, 7}) {
    for (const double runs : {9.0, 100.0, 1e6}) {
      for (const double probability : {0.5, 0.025, 1e-6}) {
        EXPECT_NEAR(largest_root_p_value(largest_root_quantile(probability, runs, n), runs, n) / probability,
                    1.0, 1e-6);
        EXPECT_NEAR(
            smallest_root_p_value(smallest_root_quantile(probability, runs, n), runs, n) / probability, 1.0,
            1e-6);
      }
    }
  }
  EXPECT_EQ(largest_root_p_value(1.3, 20.0, 1), chi_square_survival(26.0, 20.0));
  EXPECT_EQ(smallest_root_p_value(0.0, 20.0, 3), 0.0);
  EXPECT_TRUE(std::isnan(largest_root_p_value(std::nan(""), 20.0, 3)));
  EXPECT_THROW(largest_root_p_value(1.0, 3.0, 3), std::invalid_argument);
  EXPECT_THROW(smallest_root_quantile(0.0, 9.0, 3), std::invalid_argument);
}

TEST(WishartRoots, MeasuredTails) {
  constexpr int kSamples = 4000;
  std::mt19937_64 generator(41);
  std::normal_distribution<double> normal;
  for (const auto& [n, runs] : {std::pair<Index, Index>{2, 4}, {4, 10}, {4, 80}, {9, 45}}) {
    int above = 0;
    int below = 0;
    for (int sample = 0; sample < kSamples; ++sample) {
      const Matrix u = Matrix::NullaryExpr(n, runs, [&] { return normal(generator); });
      const Vector roots = Eigen::SelfAdjointEigenSolver<Matrix>(
                               u * u.transpose() / static_cast<double>(runs), Eigen::EigenvaluesOnly)
                               .eigenvalues();
      above += largest_root_p_value(roots[n - 1], static_cast<double>(runs), n) <= 0.025;
      below += smallest_root_p_value(roots[0], static_cast<double>(runs), n) <= 0.025;
    }
    const double margin = 5.0 * test::binomial_standard_error(0.025, kSamples);
    EXPECT_LE(above / 4000.0, 0.029 + margin) << n << " " << runs;
    EXPECT_GE(above / 4000.0, 0.02 - margin) << n << " " << runs;
    EXPECT_LE(below / 4000.0, 0.029 + margin) << n << " " << runs;
    EXPECT_GE(below / 4000.0, 0.02 - margin) << n << " " << runs;
  }
}

}  // namespace
}  // namespace credence::internal
