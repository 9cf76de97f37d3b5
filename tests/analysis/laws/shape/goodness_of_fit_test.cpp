#include "analysis/laws/shape/goodness_of_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/shape/uniform_histogram.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

TEST(GoodnessOfFit, KolmogorovMatchesPublishedDigits) {
  // [Marsaglia 2003]: P(D_10 < .274) = .6284796154565.
  EXPECT_NEAR(1.0 - kolmogorov_p_value(0.274, 10), 0.6284796154565, 1e-11);
  // One value: P(D_1 > d) = 2 (1 − d) for d ≥ ½.
  EXPECT_NEAR(kolmogorov_p_value(0.7, 1), 0.6, 1e-12);
  // Kolmogorov's limit: 1.3581 is the 5 % point, 1.6276 the 1 % point ([Smirnov 1948]).
  EXPECT_NEAR(kolmogorov_p_value(1.3581 / 1e4, 100000000), 0.05, 1e-4);
  EXPECT_NEAR(kolmogorov_p_value(1.6276 / 1e4, 100000000), 0.01, 1e-4);
}

TEST(GoodnessOfFit, KolmogorovIsSmoothWhereTheMethodsJoin) {
  for (const double z : {0.4, 0.6, 0.8, 1.0, 1.36, 1.63, 2.0}) {
    const double exact = kolmogorov_p_value(z / std::sqrt(140.0), 140);
    const double approximate = kolmogorov_p_value(z / std::sqrt(141.0), 141);
    EXPECT_NEAR(exact, approximate, 2e-4) << z;
  }
}

TEST(GoodnessOfFit, AndersonMatchesTheExactLimit) {
  // The series of [Anderson 1954] summed with 25 digits apart from this library (mpmath).
  constexpr double kTable[][2] = {{0.3, 0.9381576361},    {0.7, 0.5588232039},    {1.0, 0.3572666732},
                                  {1.5, 0.1764753728},    {2.492, 0.05002218636}, {3.857, 0.01024115323},
                                  {6.0, 0.0009674519415}, {8.0, 0.0001138141557}, {15.0, 7.63322318e-8}};
  for (const auto& [a, p] : kTable) {
    EXPECT_NEAR(anderson_p_value(a, 1'000'000'000), p, std::min(2e-5, 2e-3 * p)) << a;
  }
}

TEST(GoodnessOfFit, StatisticsOfAKnownSample) {
  // u = 0.1, 0.4, 0.9: D = 0.9 − 2/3; A² by hand from its definition.
  const GoodnessOfFit result = test_uniform({0.9, 0.1, 0.4});
  EXPECT_NEAR(result.kolmogorov, 2.0 / 3.0 - 0.4, 1e-12);
  const double sum = 1.0 * (std::log(0.1) + std::log(0.1)) + 3.0 * (std::log(0.4) + std::log(0.6)) +
                     5.0 * (std::log(0.9) + std::log(0.9));
  EXPECT_NEAR(result.anderson, -3.0 - sum / 3.0, 1e-12);
  EXPECT_EQ(result.count, 3);
}

TEST(GoodnessOfFit, BadDataGiveAReason) {
  EXPECT_FALSE(test_uniform(std::vector<double>{}).reason.empty());
  EXPECT_FALSE(test_uniform({0.2, std::nan("")}).reason.empty());
  EXPECT_FALSE(test_uniform({0.2, 1.5}).reason.empty());
  const GoodnessOfFit edge = test_uniform({0.0, 0.5, 1.0});
  EXPECT_EQ(edge.anderson_p_value, 0.0);
  EXPECT_GT(edge.kolmogorov_p_value, 0.5);
  EXPECT_THROW(kolmogorov_p_value(0.1, 0), std::invalid_argument);
}

struct Rates {
  double kolmogorov = 0.0, anderson = 0.0, histogram_kolmogorov = 0.0, histogram_anderson = 0.0;
};

// NIS of dimension 1, 2 and 3 in turn, scaled by `factor`.
Rates rejection_rates(int values, double factor, double alpha, int studies, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::vector<double> dof(static_cast<std::size_t>(values));
  for (std::size_t i = 0; i < dof.size(); ++i) dof[i] = 1.0 + static_cast<double>(i % 3);
  std::normal_distribution<double> normal;
  Rates rates;
  for (int study = 0; study < studies; ++study) {
    std::vector<double> nis(dof.size());
    for (std::size_t i = 0; i < nis.size(); ++i) {
      for (int j = 0; j < static_cast<int>(dof[i]); ++j) nis[i] += factor * std::pow(normal(generator), 2);
    }
    std::vector<double> uniform;
    for (std::size_t i = 0; i < nis.size(); ++i) uniform.push_back(chi_square_cdf(nis[i], dof[i]));
    UniformHistogram histogram;
    for (const double u : uniform) histogram.add(u);
    const GoodnessOfFit exact = test_uniform(uniform);
    const GoodnessOfFit binned = test_uniform(histogram);
    rates.kolmogorov += exact.kolmogorov_p_value <= alpha;
    rates.anderson += exact.anderson_p_value <= alpha;
    rates.histogram_kolmogorov += binned.kolmogorov_p_value <= alpha;
    rates.histogram_anderson += binned.anderson_p_value <= alpha;
  }
  for (double* rate :
       {&rates.kolmogorov, &rates.anderson, &rates.histogram_kolmogorov, &rates.histogram_anderson}) {
    *rate /= studies;
  }
  return rates;
}

TEST(GoodnessOfFit, CalibratedForFewAndForManyValues) {
  constexpr int kStudies = 2000;
  for (const int values : {30, 300}) {
    for (const double alpha : {0.05, 0.01}) {
      const Rates rates = rejection_rates(values, 1.0, alpha, kStudies, 9);
      const double five_errors = 5.0 * test::binomial_standard_error(alpha, kStudies);
      EXPECT_NEAR(rates.kolmogorov, alpha, five_errors) << values;
      EXPECT_NEAR(rates.anderson, alpha, five_errors) << values;
      EXPECT_LE(rates.histogram_kolmogorov, alpha + five_errors) << values;
      EXPECT_NEAR(rates.histogram_anderson, alpha, five_errors) << values;
    }
  }
}

TEST(GoodnessOfFit, FindsAWrongScale) {
  const Rates rates = rejection_rates(300, 1.5, 0.05, 300, 10);
  EXPECT_GT(rates.kolmogorov, 0.9);
  EXPECT_GT(rates.anderson, 0.95);
  EXPECT_GT(rates.histogram_anderson, 0.95);
}

TEST(UniformHistogram, MergesInAnyOrderToTheSameCounts) {
  UniformHistogram a(10), b(10), both(10);
  for (const double u : {0.05, 0.15, 0.999, 1.0, 0.0}) {
    a.add(u);
    both.add(u);
  }
  for (const double u : {0.5, -0.1, std::nan("")}) {
    b.add(u);
    both.add(u);
  }
  UniformHistogram ba = b;
  ba.merge(a);
  a.merge(b);
  EXPECT_EQ(a, both);
  EXPECT_EQ(a, ba);
  EXPECT_EQ(a.count(), 6);
  EXPECT_EQ(a.invalid(), 2);
  EXPECT_EQ(UniformHistogram(a.counts(), a.invalid()), a);
  EXPECT_FALSE(test_uniform(a).reason.empty());
  EXPECT_FALSE(test_uniform(UniformHistogram(10)).reason.empty());
  EXPECT_THROW(a.merge(UniformHistogram(11)), std::invalid_argument);
  EXPECT_THROW(UniformHistogram(1), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
