#include "analysis/laws/correlation/whiteness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

// Runs of an autoregressive vector u_k = φ u_{k−1} + √(1 − φ²) w_k, scaled by `scale`.
LagProducts simulate(Index dim, Index lags, int runs, int steps, double phi, std::mt19937_64& generator,
                     double scale = 1.0) {
  std::normal_distribution<double> normal;
  LagProducts products(dim, lags);
  LagSeries series(dim);
  for (int run = 0; run < runs; ++run) {
    series.clear();
    Vector u = Vector::NullaryExpr(dim, [&] { return normal(generator); });
    for (int k = 0; k < steps; ++k) {
      series.add(scale * u);
      const Vector w = Vector::NullaryExpr(dim, [&] { return normal(generator); });
      u = phi * u + std::sqrt(1.0 - phi * phi) * w;
    }
    products.add_run(series);
  }
  return products;
}

/// One run of a scalar.
LagSeries scalar_run(const std::vector<double>& values) {
  LagSeries run(1);
  for (const double u : values) run.add(Vector::Constant(1, u));
  return run;
}

TEST(Whiteness, OneScalarSeriesIsLjungBox) {
  std::vector<double> series{0.3, -1.2, 0.8, 0.1, -0.4, 1.9, -0.7, 0.2, 1.1, -1.5};
  for (std::size_t i = 0; i < 20; ++i) series.push_back(0.5 * series[i] + 0.1 * static_cast<double>(i % 3));
  LagProducts products(1, 5);
  products.add_run(scalar_run(series));
  double c0 = 0.0;
  for (const double u : series) c0 += u * u;
  double q = 0.0;
  const double n = static_cast<double>(series.size());
  for (std::size_t h = 1; h <= 3; ++h) {
    double c = 0.0;
    for (std::size_t k = h; k < series.size(); ++k) c += series[k] * series[k - h];
    q += n * (n + 2.0) * (c / c0) * (c / c0) / (n - static_cast<double>(h));
  }
  const WhitenessTest test = test_whiteness(products, 0.95);
  EXPECT_NEAR(test.statistic, q, 1e-12);
  EXPECT_EQ(test.dof, 3.0) << "0.6 √30 lags of the five";
  EXPECT_EQ(test.autocorrelation.size(), 5U);
  EXPECT_EQ(test.values, 30);
}

TEST(Whiteness, NoProductSpansTwoRunsOrAGap) {
  LagProducts products(1, 2);
  LagSeries run = scalar_run({1.0, 2.0});
  run.add_missing();
  run.add(Vector::Constant(1, 4.0));
  for (int i = 0; i < 2; ++i) products.add_run(run);
  EXPECT_EQ(products.pairs(0), 6);
  EXPECT_EQ(products.pairs(1), 2);
  EXPECT_EQ(products.product(1)(0, 0), 4.0);
  EXPECT_EQ(products.pairs(2), 2);
  EXPECT_EQ(products.product(2)(0, 0), 16.0);
}

// Of two components and more steps than a series has room for at first, against sums as they are written.
TEST(Whiteness, SumsOfALongRunWithGapsAreThoseOfTheDefinition) {
  constexpr Index kSteps = 300;
  std::mt19937_64 generator(11);
  std::normal_distribution<double> normal;
  LagSeries run(2);
  std::vector<Vector> values;
  for (Index k = 0; k < kSteps; ++k) {
    values.emplace_back(k % 7 == 3 ? Vector() : Vector::NullaryExpr(2, [&] { return normal(generator); }));
    if (values.back().size() == 0) {
      run.add_missing();
    } else {
      run.add(values.back());
    }
  }
  for (const Index lags : {Index{20}, LagProducts::kMostLags}) {
    LagProducts products(2, lags);
    products.add_run(run);
    for (Index h = 0; h <= lags; ++h) {
      Matrix sum = Matrix::Zero(2, 2);
      std::int64_t pairs = 0;
      for (Index k = h; k < kSteps; ++k) {
        const Vector &now = values[static_cast<std::size_t>(k)],
                     &then = values[static_cast<std::size_t>(k - h)];
        if (now.size() == 0 || then.size() == 0) continue;
        sum += now * then.transpose();
        ++pairs;
      }
      EXPECT_EQ(products.product(h), sum) << h;
      EXPECT_EQ(products.pairs(h), pairs) << h;
    }
  }
}

TEST(Whiteness, ChunksAddUpToTheWhole) {
  std::mt19937_64 generator(1);
  const LagProducts a = simulate(2, 4, 3, 20, 0.5, generator);
  const LagProducts b = simulate(2, 4, 5, 20, 0.5, generator);
  std::mt19937_64 again(1);
  const LagProducts whole = simulate(2, 4, 8, 20, 0.5, again);
  LagProducts merged = a;
  merged.merge(b);
  for (Index h = 0; h <= 4; ++h) {
    EXPECT_EQ(merged.pairs(h), whole.pairs(h));
    EXPECT_LT((merged.product(h) - whole.product(h)).norm(), 1e-12 * whole.product(0).norm());
  }
  EXPECT_THROW(merged.merge(LagProducts(3, 4)), std::invalid_argument);
  EXPECT_THROW(merged.merge(LagProducts(2, 5)), std::invalid_argument);
}

TEST(Whiteness, DoesNotDependOnScaleOrBasis) {
  std::mt19937_64 generator(2);
  const LagProducts products = simulate(2, 5, 4, 50, 0.3, generator);
  Matrix T(2, 2);
  T << 3.0, -1.0, 0.2, 0.7;
  std::vector<Matrix> transformed;
  std::vector<std::int64_t> pairs;
  for (Index h = 0; h <= 5; ++h) {
    transformed.push_back(T * products.product(h) * T.transpose());
    pairs.push_back(products.pairs(h));
  }
  EXPECT_NEAR(test_whiteness(LagProducts(transformed, pairs, 0), 0.95).statistic,
              test_whiteness(products, 0.95).statistic, 1e-9);
}

struct Shape {
  Index dim, lags;
  int runs, steps;
};

TEST(Whiteness, CalibratedForOneAndManyRunsAndComponents) {
  constexpr int kStudies = 2000;
  std::mt19937_64 generator(3);
  for (const Shape& shape : {Shape{1, 10, 1, 200}, Shape{2, 5, 10, 25}, Shape{3, 4, 20, 10}}) {
    int at_5 = 0;
    int at_1 = 0;
    double mean = 0.0;
    double outside = 0.0, lags = 0.0;
    for (int study = 0; study < kStudies; ++study) {
      // An innovation covariance that is wrong by a factor is no business of this test.
      const LagProducts products =
          simulate(shape.dim, shape.lags, shape.runs, shape.steps, 0.0, generator, 1.7);
      const WhitenessTest test = test_whiteness(products, 0.95);
      at_5 += test.p_value <= 0.05;
      at_1 += test.p_value <= 0.01;
      mean += test.statistic / kStudies;
      for (std::size_t h = 0; h < test.band.size(); ++h)
        outside += std::abs(test.autocorrelation[h]) > test.band[h] ? 1.0 : 0.0;
      lags += static_cast<double>(test.band.size());
    }
    const auto tested = static_cast<Index>(0.6 * std::sqrt(shape.runs * shape.steps));
    const auto dof = static_cast<double>(std::min(shape.lags, tested) * shape.dim * shape.dim);
    // The mean of Q is exact; 5 standard errors.
    EXPECT_NEAR(mean, dof, 5.0 * std::sqrt(2.2 * dof / kStudies));
    EXPECT_NEAR(at_5 / 2000.0, 0.05, 5.0 * test::binomial_standard_error(0.05, kStudies)) << shape.dim;
    EXPECT_NEAR(at_1 / 2000.0, 0.01, 5.0 * test::binomial_standard_error(0.01, kStudies)) << shape.dim;
    EXPECT_NEAR(outside / lags, 0.05, 0.015) << shape.dim;
  }
}

// Over all 20 lags 10.8 % of such runs are accused, of 24 values in one component 6.9 %.
TEST(Whiteness, ShortRunsAreNotAccused) {
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(5);
  for (const Shape& shape :
       {Shape{4, 20, 1, 16}, Shape{2, 20, 1, 16}, Shape{1, 20, 1, 24}, Shape{1, 20, 1, 80}}) {
    int rejected = 0;
    for (int study = 0; study < kStudies; ++study) {
      const LagProducts products = simulate(shape.dim, shape.lags, shape.runs, shape.steps, 0.0, generator);
      rejected += test_whiteness(products, 0.95).p_value <= 0.05;
    }
    EXPECT_LE(rejected, 0.05 * kStudies + 5.0 * std::sqrt(kStudies * 0.05 * 0.95)) << shape.steps;
  }
}

TEST(Whiteness, FindsCorrelationOfEitherSign) {
  std::mt19937_64 generator(4);
  for (const double phi : {0.3, -0.3}) {
    const WhitenessTest test = test_whiteness(simulate(2, 5, 10, 50, phi, generator), 0.95);
    EXPECT_FALSE(test.white);
    EXPECT_LT(test.p_value, 1e-6);
    EXPECT_NEAR(test.autocorrelation[0], phi, 0.15);
  }
}

TEST(Whiteness, DegenerateDataGiveAReason) {
  EXPECT_FALSE(test_whiteness(LagProducts(1, 3), 0.95).reason.empty());
  LagProducts one(1, 3);
  for (int run = 0; run < 2; ++run) one.add_run(scalar_run({1.0}));
  EXPECT_FALSE(test_whiteness(one, 0.95).reason.empty());
  LagProducts zero(1, 3);
  zero.add_run(scalar_run(std::vector<double>(10, 0.0)));
  EXPECT_FALSE(test_whiteness(zero, 0.95).reason.empty());
  LagProducts bad(1, 3);
  bad.add_run(scalar_run({1.0, 1.0, 1.0, 1.0, std::nan(""), 1.0, 1.0, 1.0, 1.0, 1.0}));
  EXPECT_EQ(bad.invalid(), 1);
  EXPECT_FALSE(test_whiteness(bad, 0.95).reason.empty());
  EXPECT_TRUE(std::isnan(test_whiteness(bad, 0.95).p_value));
  EXPECT_THROW(LagProducts(0, 3), std::invalid_argument);
  EXPECT_THROW(LagProducts(1, LagProducts::kMostLags + 1), std::invalid_argument);
  EXPECT_THROW(LagSeries(0), std::invalid_argument);
  EXPECT_THROW(LagProducts({Matrix::Zero(1, 1)}, {1}, 0), std::invalid_argument);
  EXPECT_THROW(LagSeries(1).add(Vector::Zero(2)), std::invalid_argument);
  EXPECT_THROW(bad.add_run(LagSeries(2)), std::invalid_argument);
  EXPECT_THROW(test_whiteness(zero, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
