#include "analysis/laws/mean/effective_sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/mean/student_positive_mean.h"
#include "analysis/laws/ten_stretches.h"
#include "core/linear_algebra/psd_root.h"
#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

// Stationary errors e_k = φ e_{k−1} + noise, of unit covariance.
double autoregressive_steps(Index dim, std::size_t steps, double phi) {
  const std::vector<Matrix> transitions(steps, phi * Matrix::Identity(dim, dim));
  const std::vector<Matrix> covariances(steps, Matrix::Identity(dim, dim));
  return linear_run_law(transitions, covariances).effective_steps;
}

TEST(EffectiveSample, LinearLawOfAnAutoregression) {
  // ‖C_kl‖² = n φ^{2|k−l|}.
  double variance = 0.0;
  for (int k = 0; k < 5; ++k) {
    for (int l = 0; l < 5; ++l) variance += 2.0 * 2.0 * std::pow(0.64, std::abs(k - l));
  }
  EXPECT_NEAR(autoregressive_steps(2, 5, 0.8), 5.0 * 20.0 / variance, 1e-12);
}

// Cumulants of zᵀ z, z ~ N(0, C): κ_j = 2^{j−1} (j − 1)! tr Cʲ, C all covariances of whitened errors at once.
TEST(EffectiveSample, LinearLawHasTheCumulantsOfTheQuadraticForm) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr Index kDim = 3, kSteps = 7;
  std::vector<Matrix> transitions, covariances;
  for (Index k = 0; k < kSteps; ++k) {
    const Matrix A = Matrix::NullaryExpr(kDim, kDim, [&] { return 0.6 * normal(random); });
    const Matrix root = Matrix::NullaryExpr(kDim, k == 0 ? 1 : 2, [&] { return normal(random); });
    transitions.push_back(A);
    covariances.push_back(root * root.transpose());
    if (k > 0) covariances.back() += A * covariances[static_cast<std::size_t>(k - 1)] * A.transpose();
  }
  Matrix joint = Matrix::Zero(kDim * kSteps, kDim * kSteps);
  for (Index k = 0; k < kSteps; ++k) {
    Matrix reached = covariances[static_cast<std::size_t>(k)];
    for (Index l = k; l < kSteps; ++l) {
      if (l > k) reached = (transitions[static_cast<std::size_t>(l)] * reached).eval();
      joint.block(l * kDim, k * kDim, kDim, kDim) = reached;
      joint.block(k * kDim, l * kDim, kDim, kDim) = reached.transpose();
    }
  }
  Matrix weight = Matrix::Zero(kDim * kSteps, kDim * kSteps);
  double dof = 0.0;
  for (Index k = 0; k < kSteps; ++k) {
    const Matrix W = psd_whitening(covariances[static_cast<std::size_t>(k)]);
    dof += static_cast<double>(W.rows());
    weight.block(k * kDim, k * kDim, kDim, kDim) = W.transpose() * W;
  }
  EXPECT_EQ(dof, 1.0 + 3.0 * (kSteps - 1));
  const Matrix C = joint * weight;
  const double variance = 2.0 * (C * C).trace(), third = 8.0 * (C * C * C).trace();
  const RunMeanLaw law = linear_run_law(transitions, covariances);
  EXPECT_NEAR(law.effective_steps, kSteps * 2.0 * dof / variance, 1e-9);
  EXPECT_NEAR(law.skewness, third / std::pow(variance, 1.5), 1e-9);
}

TEST(EffectiveSample, LimitsOfTheLinearLaw) {
  EXPECT_NEAR(autoregressive_steps(3, 20, 0.0), 20.0, 1e-12);
  EXPECT_NEAR(autoregressive_steps(3, 20, 1.0), 1.0, 1e-9);
}

TEST(EffectiveSample, KnownStatesHaveNoPartInTheLaw) {
  Matrix P = Matrix::Identity(2, 2);
  P(0, 0) = 0.0;
  EXPECT_NEAR(linear_run_law(std::vector<Matrix>(4, 0.5 * Matrix::Identity(2, 2)), std::vector<Matrix>(4, P))
                  .effective_steps,
              autoregressive_steps(1, 4, 0.5), 1e-12);
  EXPECT_THROW(linear_run_law(std::vector<Matrix>(3, P), std::vector<Matrix>(4, P)), std::invalid_argument);
  EXPECT_THROW(linear_run_law(std::vector<Matrix>(1, P), std::vector<Matrix>(1, -P)), std::invalid_argument);
}

// NEES of M runs of an autoregressive error of the given dimension, one run in each row.
Matrix simulate(Index runs, Index steps, Index dim, double phi, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  Matrix nees(runs, steps);
  for (Index run = 0; run < runs; ++run) {
    Vector e = Vector::NullaryExpr(dim, [&] { return normal(generator); });
    for (Index k = 0; k < steps; ++k) {
      nees(run, k) = e.squaredNorm();
      e = phi * e + std::sqrt(1.0 - phi * phi) * Vector::NullaryExpr(dim, [&] { return normal(generator); });
    }
  }
  return nees;
}

TEST(EffectiveSample, TimeAverageIsCalibratedWhereTheSumIsNot) {
  constexpr int kStudies = 2000;
  std::mt19937_64 generator(2);
  for (const Index runs : {12, 40}) {
    int empirical[2] = {0, 0};
    int naive = 0;
    for (int study = 0; study < kStudies; ++study) {
      const Vector sums = simulate(runs, 40, 1, 0.95, generator).rowwise().sum();
      Moments moments;
      for (const double sum : sums) moments.add(sum);
      const double p = positive_mean_p_value(moments, 40.0);
      empirical[0] += p <= 0.05;
      empirical[1] += p <= 0.01;
      naive += two_sided_p_value(sums.sum(), 40.0 * static_cast<double>(runs)) <= 0.05;
    }
    for (int i = 0; i < 2; ++i) {
      const double alpha = i == 0 ? 0.05 : 0.01;
      const double five_errors = 5.0 * test::binomial_standard_error(alpha, kStudies);
      EXPECT_NEAR(empirical[i] / 2000.0, alpha, five_errors) << runs;
    }
    EXPECT_GT(naive / 2000.0, 0.3);
  }
}

TEST(EffectiveSample, TimeAverageFindsBothDirections) {
  std::mt19937_64 generator(3);
  Moments high, low;
  for (const double sum : Vector(simulate(100, 20, 2, 0.9, generator).rowwise().sum())) {
    high.add(1.6 * sum);
    low.add(0.6 * sum);
  }
  EXPECT_LE(positive_mean_p_value(high, 40.0), 0.05);
  EXPECT_GT(positive_mean_interval(high, 0.95).lower, 40.0);
  EXPECT_LE(positive_mean_p_value(low, 40.0), 0.05);
  EXPECT_LT(positive_mean_interval(low, 0.95).upper, 40.0);
}

TEST(EffectiveSample, CorrelationTimeOfSquaredAutoregression) {
  // ρ_h = φ^{2h}: τ = (1 + φ²) / (1 − φ²).
  std::mt19937_64 generator(4);
  for (const double phi : {0.0, 0.7, 0.9}) {
    const Matrix nees = simulate(1, 50000, 1, phi, generator);
    const std::vector<double> series(nees.data(), nees.data() + nees.size());
    const EffectiveSample sample = effective_sample(std::vector<std::span<const double>>{series}, 1.0);
    const double exact = (1.0 + phi * phi) / (1.0 - phi * phi);
    EXPECT_NEAR(sample.correlation_time / exact, 1.0, 0.15) << phi;
    EXPECT_NEAR(sample.size, 50000.0 / sample.correlation_time, 1e-6);
  }
  EXPECT_FALSE(effective_sample({}, 1.0).reason.empty());
  const std::vector<double> constant(10, 1.0);
  EXPECT_FALSE(effective_sample(std::vector<std::span<const double>>{constant}, 1.0).reason.empty());
}

// A scale of 2^k changes no bit of a ratio.
TEST(EffectiveSample, AboutItsOwnMeanASeriesIsWorthTheSameAtAnyScale) {
  EXPECT_EQ(average_of(std::vector<double>{1.0, 2.0, 6.0}), 3.0);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> series(500), larger;
  double x = 0.0;
  for (double& value : series) value = 1.0 + (x = 0.9 * x + normal(random));
  for (const double value : series) larger.push_back(4.0 * value);
  const EffectiveSample sample = effective_sample(series);
  EXPECT_GT(sample.correlation_time, 5.0);
  EXPECT_EQ(effective_sample(larger).correlation_time, sample.correlation_time);
  EXPECT_EQ(effective_sample(larger).size, sample.size);
}

TEST(EffectiveSample, SingleRunIsCalibrated) {
  constexpr int kStudies = 2000;
  std::mt19937_64 generator(5);
  int at_5 = 0;
  int at_1 = 0;
  int found = 0;
  int undecided = 0;
  for (int study = 0; study < kStudies; ++study) {
    const Matrix nees = simulate(1, 1000, 2, 0.7, generator) / 2.0;
    std::vector<double> series(nees.data(), nees.data() + nees.size());
    const TimeAverageTest test = test_single_run(series, 0.95);
    undecided += std::isnan(test.p_value);
    at_5 += test.p_value <= 0.05;
    at_1 += test.p_value <= 0.01;
    for (double& x : series) x *= 1.6;
    const TimeAverageTest large = test_single_run(series, 0.95);
    found += large.p_value <= 0.05 && large.average.mean > 1.0;
  }
  EXPECT_NEAR(at_5 / 2000.0, 0.05, 5.0 * test::binomial_standard_error(0.05, kStudies));
  EXPECT_NEAR(at_1 / 2000.0, 0.01, 5.0 * test::binomial_standard_error(0.01, kStudies));
  EXPECT_GT(found / 2000.0, 0.8);
  EXPECT_LE(undecided, 2);
}

TEST(EffectiveSample, ASingleRunIsTestedAtSeveralLevelsAsAtEach) {
  std::mt19937_64 generator(7);
  const Matrix nees = simulate(1, 1000, 2, 0.7, generator) / 2.0;
  const std::vector<double> series(nees.data(), nees.data() + nees.size());
  const std::vector<TimeAverageTest> tests = test_single_run(series, {0.8, 0.95});
  ASSERT_EQ(tests.size(), 2U);
  EXPECT_EQ(tests[0].average.upper, test_single_run(series, 0.8).average.upper);
  EXPECT_EQ(tests[1].average.upper, test_single_run(series, 0.95).average.upper);
  EXPECT_GT(tests[1].average.upper, tests[0].average.upper);
  EXPECT_EQ(tests[1].p_value, tests[0].p_value);
  EXPECT_FALSE(test_single_run({}, {0.8, 0.95})[1].average.reason.empty());
}

// τ by the sums as they are defined, lag by lag, one product after the other.
double plain_correlation_time(std::span<const std::span<const double>> series, double mean) {
  const auto at = [&](std::size_t lag, double& pairs) {
    double sum = pairs = 0.0;
    for (const auto& x : series) {
      for (std::size_t k = lag; k < x.size(); ++k, pairs += 1.0) sum += (x[k] - mean) * (x[k - lag] - mean);
    }
    return sum;
  };
  double values = 0.0, pairs = 0.0, time = 1.0;
  const double squares = at(0, values);
  for (std::size_t lag = 1; lag < series.front().size() && static_cast<double>(lag) < 5.0 * time; ++lag) {
    const double sum = at(lag, pairs);
    time += 2.0 * (sum / pairs) / (squares / values);
  }
  return std::max(1.0, time);
}

TEST(EffectiveSample, SeveralLagsAtOnceHaveTheBitsOfEach) {
  std::mt19937_64 generator(12);
  for (const double phi : {0.0, 0.7, 0.95}) {
    const Matrix nees = simulate(1, 400, 1, phi, generator);
    const std::vector<double> all(nees.data(), nees.data() + nees.size());
    // The longest first; one is shorter than the lags that are looked at.
    for (const std::size_t length : {1U, 3U, 8U, 9U, 100U}) {
      const std::vector<std::span<const double>> series{std::span(all).first(250),
                                                        std::span(all).subspan(250, length)};
      EXPECT_EQ(effective_sample(series, 1.0).correlation_time, plain_correlation_time(series, 1.0))
          << phi << ", " << length;
    }
  }
}

TEST(EffectiveSample, AShortRunIsUndecided) {
  std::mt19937_64 generator(6);
  const Matrix nees = simulate(1, 60, 1, 0.95, generator);
  const std::vector<double> series(nees.data(), nees.data() + nees.size());
  EXPECT_TRUE(std::isnan(test_single_run(series, 0.95).p_value));
  EXPECT_FALSE(test_single_run(series, 0.95).average.reason.empty());
  EXPECT_GT(test_single_run(series, 0.95).effective_steps, 0.0);  // what is too few
  EXPECT_FALSE(test_single_run({}, 0.95).average.reason.empty());
}

std::vector<std::vector<double>> squared_normals(std::size_t runs, std::size_t steps,
                                                 std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> all(runs, std::vector<double>(steps));
  for (auto& run : all) {
    for (double& x : run) x = std::pow(normal(random), 2);
  }
  return all;
}

// Row k of each of two runs is k; τ = 1 takes each alone, τ = 1.5 pairs, of which the last of five is one.
TEST(AveragesByPlace, AreOfTheWholeOfTenthsAndFromTheStart) {
  std::vector<double> rows(50);
  std::iota(rows.begin(), rows.end(), 0.0);
  const std::vector<std::vector<double>> runs(2, rows);
  const std::vector<SkewedMoments> each = averages_by_place(runs, 1.0);
  ASSERT_EQ(each.size(), 1U + 10U + 6U);
  EXPECT_EQ(each[0].count, 100);
  EXPECT_NEAR(each[0].mean, 24.5, 1e-12);
  EXPECT_EQ(each[10].count, 10);
  EXPECT_NEAR(each[10].mean, 47.0, 1e-12);  // 45 to 49
  EXPECT_EQ(each[11].mean, 0.0);            // row 1
  EXPECT_NEAR(each[13].mean, 4.5, 1e-12);   // rows 4 to 7
  EXPECT_EQ(each[16].count, 2 * 19);        // rows 32 to 50
  const std::vector<SkewedMoments> pairs = averages_by_place(runs, 1.5);
  EXPECT_EQ(pairs[0].count, 50);
  EXPECT_NEAR(pairs[0].mean, 24.5, 1e-12);
  EXPECT_EQ(averages_by_place({}, 1.0)[0].count, 0);
}

TEST(StretchAverages, AreOfAtLeastTwentyStretches) {
  std::mt19937_64 random(3);
  for (const std::size_t runs : {2U, 5U, 7U, 19U}) {
    const StretchAverages stretches = stretch_averages(squared_normals(runs, 400, random));
    const SkewedMoments& averages = stretches.averages;
    const double rows = 400.0 * static_cast<double>(runs);
    EXPECT_GT(stretches.effective_rows, 0.7 * rows);
    EXPECT_LE(stretches.effective_rows, rows);
    EXPECT_EQ(averages.count, static_cast<std::int64_t>((20 + runs - 1) / runs * runs));
    EXPECT_NEAR(averages.mean, 1.0, 5.0 * std::sqrt(2.0 / rows));
  }
  EXPECT_EQ(stretch_averages(squared_normals(1, 400, random)).averages.count, 20);
  EXPECT_EQ(stretch_averages(squared_normals(20, 400, random)).averages.count, 0);
}

TEST(StandingShare, IsTheLargestOfAnyDirection) {
  // The averages are (1, 1) of errors with mean squares [2 1; 1 4]: (1, 1) A⁻¹ (1, 1)ᵀ = (4 − 2 + 2)/7.
  const Matrix A{{2.0, 1.0}, {1.0, 4.0}}, ones = Matrix::Ones(2, 2);
  EXPECT_NEAR(standing_share(A, ones), 4.0 / 7.0, 1e-8);
  EXPECT_NEAR(standing_share(9.0 * A, 9.0 * ones), 4.0 / 7.0, 1e-8) << "whatever the scale";
  // What stays is found however small it is.
  EXPECT_NEAR(standing_share(Matrix{{1.0, 0.0}, {0.0, 1e-4}}, Matrix{{0.0, 0.0}, {0.0, 1e-4}}), 1.0, 1e-4);
  EXPECT_EQ(standing_share(A, Matrix::Zero(2, 2)), 0.0);
  EXPECT_EQ(standing_share(Matrix::Zero(2, 2), Matrix::Zero(2, 2)), 0.0);
  EXPECT_EQ(standing_share(Matrix(0, 0), Matrix(0, 0)), 0.0);
}

/// Waves of 47 rows and this phase, the second state with `white` of white noise in square.
Matrix waves(double phase, double white, double size = 1.0) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Matrix errors(2, 500);
  for (Index k = 0; k < errors.cols(); ++k) {
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(k) / 47.0 + phase;
    errors(0, k) = normal(random);
    errors(1, k) =
        size * (std::sqrt(2.0 * (1.0 - white)) * std::sin(turn) + std::sqrt(white) * normal(random));
  }
  return errors;
}

// A wave of 47 rows is 1.06 of the 50 of a tenth, 0.06 from a frequency of the grid, which takes 1 − (π
// 0.06)²/3 of it.
TEST(OscillatingShare, IsThatOfAWaveInItsDirection) {
  for (const double phase : {0.0, 1.0, 2.5}) {
    EXPECT_NEAR(oscillating_share(waves(phase, 0.0)), 0.99, 0.01) << phase;
    EXPECT_NEAR(oscillating_share(waves(phase, 0.0, 1e-3)), 0.99, 0.01) << "however small it is";
    // Of white noise two of 50 degrees of freedom are taken, and chance adds some.
    EXPECT_NEAR(oscillating_share(waves(phase, 0.4)), 0.6 + 0.4 * 2.0 / 50.0, 0.06) << phase;
  }
  EXPECT_LT(oscillating_share(waves(0.0, 1.0)), least_standing_share(2, kOscillatingStretches, 500.0));
}

TEST(OscillatingShare, OfOneStateThatTurnsAtEveryRowIsAll) {
  Matrix errors(1, 400);
  for (Index k = 0; k < errors.cols(); ++k) errors(0, k) = k % 2 == 0 ? 2.0 : -2.0;
  EXPECT_NEAR(oscillating_share(errors), 1.0, 1e-8);
  EXPECT_EQ(oscillating_share(errors.leftCols(39)), 0.0) << "too few";
  EXPECT_EQ(oscillating_share(Matrix(0, 0)), 0.0);
}

TEST(StandingShare, AllowsForWhatChanceLeaves) {
  // 40 directions, 10 stretches, N = 61: asin √(9.5/60) + asin √(39.5/60) = 0.40924 + 0.94650, whose sine
  // squared is 0.95446.
  EXPECT_NEAR(least_standing_share(40, 10, 61.0 / 0.6), (1.0 + 2.0 * 0.95446) / 3.0, 1e-4);
  EXPECT_EQ(least_standing_share(40, 10, 50.0), 1.0) << "any direction may be as large";
  EXPECT_EQ(least_standing_share(40, 10, 1.0), 1.0);
  EXPECT_EQ(least_standing_share(4, 10, 5000.0), kStandingErrors);
  EXPECT_GT(least_standing_share(12, 10, 140.0), least_standing_share(4, 10, 140.0));
  EXPECT_LT(least_standing_share(12, 20, 280.0), least_standing_share(12, 10, 140.0)) << "two runs";
}

// Of errors that are all forgotten alike, in 12 and in 40 directions: the largest share stays below the limit
// of runs like these, and is nearer to what chance leaves than to 1.
TEST(StandingShare, OfErrorsThatAreForgottenStaysBelowTheLimit) {
  constexpr Index kRows = 500, kLength = kRows / 10;
  constexpr int kStudies = 20;
  constexpr double kMemory = 0.8;
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  for (const Index directions : {12, 40}) {
    std::vector<double> shares;
    double size = 0.0;
    for (int study = 0; study < kStudies; ++study) {
      Vector u = Vector::NullaryExpr(directions, [&] { return normal(random); });
      Matrix square = Matrix::Zero(directions, directions), of_means = square;
      std::vector<double> nees;
      for (Index stretch = 0; stretch < 10; ++stretch) {
        Vector mean = Vector::Zero(directions);
        for (Index k = 0; k < kLength; ++k) {
          for (double& x : u) x = kMemory * x + std::sqrt(1.0 - kMemory * kMemory) * normal(random);
          mean += u / static_cast<double>(kLength);
          square += u * u.transpose() / static_cast<double>(kRows);
          nees.push_back(u.squaredNorm());
        }
        of_means += 0.1 * mean * mean.transpose();
      }
      shares.push_back(standing_share(square, of_means));
      const std::vector<std::span<const double>> series{nees};
      size += effective_sample(series, static_cast<double>(directions)).size / kStudies;
    }
    const double limit = least_standing_share(directions, 10, size);
    EXPECT_GT(limit, kStandingErrors);
    EXPECT_LT(std::ranges::max(shares), limit) << directions;
    // The limit is (1 + 2θ)/3.
    EXPECT_GT(std::ranges::min(shares), (1.5 * limit - 0.5) - 0.25) << directions;
  }
}

TEST(StretchAverages, NoneWhereTheRunsAreTooShortForTheirCorrelation) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> runs(10, std::vector<double>(100));
  for (auto& run : runs) {
    double x = normal(random);
    for (double& value : run) {
      x = 0.95 * x + std::sqrt(1.0 - 0.95 * 0.95) * normal(random);
      value = x * x;
    }
  }
  EXPECT_EQ(stretch_averages(runs).averages.count, 0);
  EXPECT_EQ(stretch_averages({}).averages.count, 0);
}

// A run that was broken off leaves the others as they are.
TEST(StretchAverages, AShortRunBesideLongOnesIsLeftOut) {
  std::vector<double> whole;
  for (int k = 0; k < 2000; ++k) whole.push_back(k % 3 == 0 ? 1.5 : 0.7);
  const std::vector<double> broken(whole.begin(), whole.begin() + 20);
  const auto averages = [](const std::vector<std::vector<double>>& runs) {
    return stretch_averages(runs).averages;
  };
  EXPECT_EQ(averages({whole, broken}).count, 20);
  EXPECT_EQ(averages({broken, whole, whole}).count, 20);
  EXPECT_EQ(averages({broken, broken}).count, 0);
  const std::vector<double> half(whole.begin(), whole.begin() + 1000);
  EXPECT_EQ(averages({whole, half}).count, 30) << "of 100 rows each";
  EXPECT_EQ(averages({whole, broken}).mean, averages({whole}).mean);
}

TEST(StretchAverages, ShortRunsBesideLongOnesAreCutOneBehindTheOther) {
  std::vector<double> whole, few;
  for (int i = 0; i < 2000; ++i) whole.push_back(i % 3 == 0 ? 1.5 : 0.75);
  for (int i = 0; i < 30; ++i) few.push_back(i % 3 == 0 ? 1.6 : 0.85);
  std::vector<std::vector<double>> runs = {whole, few, few, few, few};  // stretches of 100 rows
  const auto averages = stretch_averages(runs).averages;
  const double of_whole = stretch_averages(std::span(runs).first(1)).averages.mean;
  EXPECT_EQ(averages.count, 21);
  EXPECT_NEAR(averages.mean, (20.0 * of_whole + 1.1) / 21.0, 1e-3);  // the last piece is cut within a pattern
  runs.push_back(few);                                               // 50 rows more than a stretch
  EXPECT_EQ(stretch_averages(runs).averages.count, 22);
}

TEST(EffectiveSample, OfSeveralSeriesIsAboutTheirCommonMean) {
  const std::vector<std::vector<double>> runs = {{1.0, 3.0, 2.0, 4.0, 2.5}, {5.0, 6.0, 4.5}};
  const std::vector<std::span<const double>> views(runs.begin(), runs.end());
  const EffectiveSample common = effective_sample(runs), wanted = effective_sample(views, 28.0 / 8.0);
  EXPECT_EQ(common.correlation_time, wanted.correlation_time);
  EXPECT_EQ(common.size, wanted.size);
  EXPECT_FALSE(effective_sample(std::vector<std::vector<double>>{}).reason.empty());
}

/// Runs of autoregressions about a mean of 0.2, mixed.
std::vector<Matrix> autoregressions(std::uint64_t seed, Index dim, Index vectors, std::size_t runs,
                                    double phi) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto fresh = [&] { return Vector(Vector::NullaryExpr(dim, [&] { return normal(random); })); };
  Matrix mix = Matrix::Identity(dim, dim);
  mix.row(0) *= 3.0;
  mix.col(0).setConstant(2.0);
  std::vector<Matrix> result;
  for (std::size_t r = 0; r < runs; ++r) {
    Matrix& run = result.emplace_back(dim, vectors);
    Vector e = fresh();
    for (Index k = 0; k < vectors; ++k) {
      run.col(k) = mix * e + Vector::Constant(dim, 0.2);
      e = phi * e + std::sqrt(1.0 - phi * phi) * fresh();
    }
  }
  return result;
}

// ‖R_h‖²/n = φ^{2h}, however the components are mixed.
TEST(MemoryOfSquares, IsThatOfTheSquaresOfAutoregressions) {
  for (const double phi : {0.0, 0.5, 0.9}) {
    const double exact = (1.0 + phi * phi) / (1.0 - phi * phi);
    EXPECT_NEAR(memory_of_squares(autoregressions(1, 3, 20'000, 1, phi)) / exact, 1.0, 0.05) << phi;
    EXPECT_NEAR(memory_of_squares(autoregressions(2, 2, 1000, 15, phi)) / exact, 1.0, 0.07) << phi;
  }
}

TEST(MemoryOfSquares, HasLittleBiasOfFewVectorsOfManyComponents) {
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
    sum += memory_of_squares(autoregressions(seed, 8, 300, 1, 0.8)) / 100.0;
  EXPECT_NEAR(sum / (1.64 / 0.36), 1.0, 0.15) << "uncorrected it would be 4.9";
}

TEST(MemoryOfSquares, IsNoneOfWhatCannotBeWhitened) {
  EXPECT_TRUE(std::isnan(memory_of_squares({})));
  EXPECT_TRUE(std::isnan(memory_of_squares(std::vector<Matrix>{Matrix::Zero(2, 50)})));
  EXPECT_TRUE(std::isnan(memory_of_squares(std::vector<Matrix>{Matrix(2, 0)})));
}

// 200 rows of NEES that are worth all of them by themselves.
TEST(MemoryOfSquares, DecidesHowLongAStretchMustBe) {
  std::vector<double> nees;
  for (int k = 0; k < 200; ++k) nees.push_back(k % 3 == 0 ? 1.5 : 0.7);
  const auto is_tested = [&](double memory) {
    return test_single_run(nees, {0.95}, memory).front().average.reason.empty();
  };
  EXPECT_TRUE(is_tested(kNaN));
  EXPECT_TRUE(is_tested(20.0 / 7.0));
  EXPECT_FALSE(is_tested(2.9));
  const auto stretches = [&](double memory) {
    return stretch_averages(std::span(&nees, 1), memory).averages.count;
  };
  EXPECT_EQ(stretches(kNaN), 20);
  EXPECT_EQ(stretches(10.0 / 7.0), 20);
  EXPECT_EQ(stretches(1.5), 0);
}

TEST(MemoryOfSquares, AStretchIsNoShorterThanHalfOfWhatNeesTells) {
  EXPECT_EQ(shortest_stretch(8.0, kNaN), 80.0);
  EXPECT_EQ(shortest_stretch(8.0, 6.0), 42.0);
  EXPECT_EQ(shortest_stretch(8.0, 3.0), 40.0);
}

}  // namespace
}  // namespace credence::internal
