#include "analysis/studies/selftest_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <set>

#include "montecarlo/engine/moments.h"

namespace credence::internal {
namespace {

constexpr int kLast = SyntheticFilter::kSteps - 1;
constexpr double kR = 0.01;   // rad², of either measurement
constexpr double kP0 = 0.01;  // rad²

Eigen::Matrix2d observation() { return (Eigen::Matrix2d() << -1.0, 1.0, 1.0, 0.0).finished(); }

Eigen::Matrix2d heading_noise(double q) { return Eigen::Vector2d(q, 0.0).asDiagonal(); }

TEST(SyntheticFilter, ItsCovarianceIsThatOfTheInformationFilter) {
  // P⁺⁻¹ = (P + Q)⁻¹ + Hᵀ R⁻¹ H, without a gain and without Joseph's form.
  const SyntheticSetup setup{.noise_ratio = 0.1, .process_scale = 4.0, .measurement_scale = 0.5};
  const SyntheticFilter filter(setup);
  const Eigen::Matrix2d H = observation();
  Eigen::Matrix2d P = kP0 * Eigen::Matrix2d::Identity();
  for (int k = 0; k < SyntheticFilter::kSteps; ++k) {
    const Eigen::Matrix2d prior = P + heading_noise(4.0 * 0.1 * kR);
    const Eigen::Matrix2d S = H * prior * H.transpose() + 0.5 * kR * Eigen::Matrix2d::Identity();
    P = (prior.inverse() + H.transpose() * H / (0.5 * kR)).inverse();
    EXPECT_TRUE(filter.covariance(k).isApprox(P, 1e-11)) << k;
    EXPECT_TRUE(filter.innovation_covariance(k).isApprox(S, 1e-11)) << k;
  }
  EXPECT_EQ(filter.assumed_measurement_variance(), 0.5 * kR);
}

TEST(SyntheticFilter, AMissingMeasurementLeavesThePrior) {
  const SyntheticFilter filter({.noise_ratio = 1.0, .every_third_missing = true});
  for (int k = 0; k < SyntheticFilter::kSteps; ++k) {
    EXPECT_EQ(filter.missing(k), k % 3 == 2);
    if (!filter.missing(k)) continue;
    EXPECT_TRUE(filter.covariance(k).isApprox(filter.covariance(k - 1) + heading_noise(kR), 1e-13)) << k;
    EXPECT_EQ(filter.transitions()[static_cast<std::size_t>(k)], Matrix::Identity(2, 2));
  }
}

/// Moments of NEES and NIS at one step.
struct StepMoments {
  Moments nees, nis;
};

StepMoments moments_at(const SyntheticFilter& filter, int k, int blocks) {
  const NoiseSource noise(11, 1);
  StepMoments moments;
  for (int block = 0; block < blocks; ++block) {
    const SyntheticFilter::Sample sample = filter.simulate(noise, block)[static_cast<std::size_t>(k)];
    for (const double value : filter.nees(k, sample.error)) moments.nees.add(value);
    for (const double value : filter.nis(k, sample.innovation)) moments.nis.add(value);
  }
  return moments;
}

/// The law of a quadratic form eᵀ P⁻¹ e of Gaussian errors of covariance Σ: mean tr(P⁻¹Σ), variance
/// 2 tr((P⁻¹Σ)²).
void expect_law(const Moments& seen, const Eigen::Matrix2d& P, const Eigen::Matrix2d& sigma,
                const std::string& what) {
  const Eigen::Matrix2d ratio = P.llt().solve(sigma);
  const double error = std::sqrt(2.0 * (ratio * ratio).trace() / static_cast<double>(seen.count));
  EXPECT_NEAR(seen.mean, ratio.trace(), 5.0 * error) << what;
}

TEST(SyntheticFilter, ErrorsOfAWrongFilterHaveTheMomentsOfItsGain) {
  // Σ⁺ = A (Σ + Q) Aᵀ + K R Kᵀ with the true Q and R and the filter's A = I − K H, and Σ_ν = H (Σ + Q) Hᵀ +
  // R.
  constexpr int kBlocks = 400;
  const Eigen::Matrix2d H = observation();
  for (const Defect defect : {Defect::none, Defect::process_noise_too_small, Defect::process_noise_too_large,
                              Defect::measurement_noise_too_small, Defect::measurement_noise_too_large,
                              Defect::initial_covariance, Defect::dropped_cross_covariance}) {
    const SyntheticSetup setup = setup_of(defect);
    const SyntheticFilter filter(setup);
    const std::vector<Matrix> A = filter.transitions();
    Eigen::Matrix2d sigma = kP0 * Eigen::Matrix2d::Identity();
    for (int k = 0; k < SyntheticFilter::kSteps; ++k) {
      const Eigen::Matrix2d Ak = A[static_cast<std::size_t>(k)];
      const Eigen::Matrix2d K = (Eigen::Matrix2d::Identity() - Ak) * H.inverse();
      const Eigen::Matrix2d prior = sigma + heading_noise(setup.noise_ratio * kR);
      sigma = Ak * prior * Ak.transpose() + kR * K * K.transpose();
      if (defect == Defect::dropped_cross_covariance) EXPECT_EQ(filter.covariance(k)(0, 1), 0.0);
      if (k != 0 && k != 7 && k != kLast) continue;
      const StepMoments seen = moments_at(filter, k, kBlocks);
      const std::string what = std::string(to_string(defect)) + " at " + std::to_string(k);
      expect_law(seen.nees, filter.covariance(k), sigma, what);
      expect_law(seen.nis, filter.innovation_covariance(k),
                 H * prior * H.transpose() + kR * Eigen::Matrix2d::Identity(), what);
    }
  }
}

/// Moments of the compass's innovation at a step, of 8 to 16 thousand runs.
Moments compass(Defect defect, int k) {
  const SyntheticFilter filter(setup_of(defect));
  const NoiseSource noise(12, 1);
  Moments moments;
  for (int block = 0; block < 1000; ++block) {
    const auto steps = filter.simulate(noise, block);
    for (const double nu : steps[static_cast<std::size_t>(k)].innovation.row(1)) moments.add(nu);
  }
  return moments;
}

TEST(SyntheticFilter, ABiasIsThatOfTheCompassAndHeavyTailsKeepTheVariance) {
  // At the first step ν = w − e has variance P0 + Q + R.
  const double variance = kP0 + 0.0025 * kR + kR;
  const Moments biased = compass(Defect::biased_measurement, 0);
  const double error = std::sqrt(variance / static_cast<double>(biased.count));
  EXPECT_NEAR(biased.mean, 0.8 * std::sqrt(kR), 5.0 * error);
  const Moments heavy = compass(Defect::heavy_tails, 0), right = compass(Defect::none, 0);
  EXPECT_NEAR(heavy.mean, 0.0, 5.0 * error);
  // E w⁴ = 3 R² (0.9 + 0.1 · 9²) / 1.8² = 3 R² · 2.78; of ν = w − e with e Gaussian of variance V:
  const double R = kR, V = variance - kR, fourth = 3.0 * R * R * 9.0 / 3.24 + 6.0 * R * V + 3.0 * V * V;
  const double of_variance = std::sqrt((fourth - variance * variance) / static_cast<double>(heavy.count));
  EXPECT_NEAR(heavy.variance(), variance, 5.0 * of_variance);
  EXPECT_NEAR(right.variance(), variance, 5.0 * variance * std::sqrt(2.0 / static_cast<double>(right.count)));
}

TEST(SyntheticFilter, ColouredNoiseHasTheVarianceOfWhiteAtEveryStep) {
  // Innovations of the first step are those of white noise; later ones are correlated with them.
  const Moments coloured = compass(Defect::coloured_noise, 0), white = compass(Defect::none, 0);
  EXPECT_EQ(coloured.mean, white.mean);
  EXPECT_EQ(coloured.m2, white.m2);
}

TEST(SyntheticFilter, HeadingErrorsAreWrappedAndTheLoggedScaleChangesNothing) {
  const NoiseSource noise(13, 1);
  const SyntheticFilter unwrapped(setup_of(Defect::unwrapped_angle));
  double largest = 0.0;
  for (const auto& sample : unwrapped.simulate(noise, 0)) {
    EXPECT_LE(sample.error.row(0).cwiseAbs().maxCoeff(), std::numbers::pi);
    largest = std::max(largest, sample.innovation.row(1).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(largest, std::numbers::pi) << "forty steps of 0.2 rad cross ±π in every run";
  const SyntheticFilter one({}), scaled({.logged_scale = 4.0});
  EXPECT_EQ(one.simulate(noise, 2)[kLast].error, scaled.simulate(noise, 2)[kLast].error);
  EXPECT_EQ(one.covariance(kLast), scaled.covariance(kLast));
}

TEST(SyntheticFilter, RunsDependOnTheirBlockAlone) {
  const SyntheticFilter filter({});
  const NoiseSource noise(14, 1);
  EXPECT_EQ(filter.simulate(noise, 3)[5].error, filter.simulate(noise, 3)[5].error);
  EXPECT_NE(filter.simulate(noise, 3)[5].error, filter.simulate(noise, 4)[5].error);
}

TEST(Defects, EachHasWordsOfItsOwn) {
  std::set<std::string_view> words;
  for (int i = 0; i <= static_cast<int>(Defect::shared_prior); ++i) {
    words.insert(to_string(static_cast<Defect>(i)));
    EXPECT_EQ(setup_of(static_cast<Defect>(i)).defect, static_cast<Defect>(i));
  }
  EXPECT_EQ(words.size(), static_cast<std::size_t>(Defect::shared_prior) + 1);
}

}  // namespace
}  // namespace credence::internal
