#include "analysis/laws/shape/covariance_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/chi_square/chi_square_cumulants.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

// M errors with the given standard deviations, whitened by a P that claims 1 everywhere.
VectorMoments draw(const Vector& deviations, int runs, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  VectorMoments moments;
  for (int run = 0; run < runs; ++run) {
    moments.add(Vector(deviations.array() *
                       Vector::NullaryExpr(deviations.size(), [&] { return normal(generator); }).array()));
  }
  return moments;
}

TEST(CovarianceShape, OneDimensionByHand) {
  // C = 1.5 about zero: LR = M (C − ln C − 1), h = 10, and its cumulants from ψ(10) = 2.2517525890667,
  // ψ'(10) = 0.1051663356817, ψ''(10) = −0.0110498349708.
  const Cumulants one_dimension{
      .mean = 1.0166500785465, .variance = 2.0665342722987, .third = 8.3986797664165};
  VectorMoments moments;
  for (int run = 0; run < 20; ++run) moments.add(Vector::Constant(1, std::sqrt(1.5)));
  const CovarianceShape shape = test_covariance_shape(moments, 0.95);
  EXPECT_NEAR(shape.p_value, upper_p_value(20.0 * (0.5 - std::log(1.5)), one_dimension), 1e-10);
  EXPECT_NEAR(shape.factors[0], 1.5, 1e-12);
  // At the δ that is proved one of the two tests is at its level: of the largest factor, or of the smallest.
  const double within = 1.0 + shape.proved_within;
  EXPECT_NEAR(std::max(chi_square_cdf(30.0 / within, 20.0), chi_square_survival(30.0 * within, 20.0)), 0.05,
              1e-9);
}

TEST(CovarianceShape, KeepsItsLevel) {
  constexpr int kSamples = 4000;
  std::mt19937_64 generator(51);
  for (const auto& [n, runs] : {std::pair<Index, int>{1, 3}, {3, 4}, {4, 8}, {4, 100}, {8, 20}}) {
    int rejected = 0;
    for (int sample = 0; sample < kSamples; ++sample) {
      rejected += test_covariance_shape(draw(Vector::Ones(n), runs, generator), 0.95).p_value <= 0.05;
    }
    EXPECT_NEAR(rejected / 4000.0, 0.05, 5.0 * test::binomial_standard_error(0.05, kSamples))
        << n << " " << runs;
  }
}

TEST(CovarianceShape, SeesWhatTheMeanOfNeesCannot) {
  // tr Σ = n exactly: one direction optimistic, one pessimistic.
  constexpr int kSamples = 300;
  const Vector deviations{{std::sqrt(0.5), 1.0, std::sqrt(1.5)}};
  std::mt19937_64 generator(52);
  int rejected = 0;
  for (int sample = 0; sample < kSamples; ++sample) {
    const CovarianceShape shape = test_covariance_shape(draw(deviations, 200, generator), 0.95);
    rejected += shape.p_value <= 0.05;
  }
  EXPECT_GT(rejected, 290);
}

TEST(CovarianceShape, ProvesNoMoreThanIsTrue) {
  // One direction is off by exactly 1.2: "within 1.2" may be proved in 5 % of the samples, within 1.5 mostly
  // is.
  constexpr int kSamples = 2000;
  std::mt19937_64 generator(53);
  for (const double factor : {1.2, 1.0 / 1.2}) {
    const Vector deviations{{1.0, std::sqrt(factor)}};
    int wrongly = 0;
    int rightly = 0;
    for (int sample = 0; sample < kSamples; ++sample) {
      const CovarianceShape shape = test_covariance_shape(draw(deviations, 400, generator), 0.95);
      wrongly += shape.proved_within <= 0.2;
      rightly += shape.proved_within <= 0.5;
    }
    EXPECT_LE(wrongly / 2000.0, 0.05 + 5.0 * test::binomial_standard_error(0.05, kSamples));
    EXPECT_GT(rightly / 2000.0, 0.75);
  }
}

TEST(CovarianceShape, DegenerateSamples) {
  EXPECT_EQ(test_covariance_shape({}, 0.95).reason, "no components");
  std::mt19937_64 generator(54);
  EXPECT_EQ(test_covariance_shape(draw(Vector::Ones(3), 3, generator), 0.95).reason,
            "not more runs than components");
  // A direction without error: P is infinitely too large in it, and nothing is proved.
  const CovarianceShape flat = test_covariance_shape(draw(Vector{{1.0, 0.0}}, 30, generator), 0.95);
  EXPECT_EQ(flat.p_value, 0.0);
  EXPECT_EQ(flat.factors[0], 0.0);
  EXPECT_EQ(flat.proved_within, std::numeric_limits<double>::infinity());
  VectorMoments infinite;
  for (int run = 0; run < 3; ++run)
    infinite.add(Vector::Constant(1, std::numeric_limits<double>::infinity()));
  EXPECT_EQ(test_covariance_shape(infinite, 0.95).reason, "an error is not finite");
  EXPECT_THROW(test_covariance_shape({}, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
