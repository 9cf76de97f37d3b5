#include "analysis/tuning/tuning.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "analysis/laws/chi_square/chi_square.h"
#include "tests/analysis/tuning/local_level.h"
#include "tests/analysis/tuning/other_methods.h"
#include "tests/analysis/tuning/quadratic_score.h"

namespace credence::internal {
namespace {

using testing::local_level;
using testing::simulate;
using testing::survey_model;

Tuning tune_linear(const LinearModel& present, const char* free, std::vector<MeasuredRun> runs) {
  const LinearScore score({present, parse_free_noise(free)}, std::move(runs));
  return tune(score, score.noise().start());
}

TEST(Tuning, FindsTheNoiseOfALocalLevel) {
  const auto runs = simulate(local_level(0.1, 1.0), 40, 500, 1);
  const Tuning tuning = tune_linear(local_level(0.3, 0.78), "diag(Q),diag(R)", runs);
  ASSERT_EQ(tuning.parameters.size(), 2u);
  for (const auto& [at, truth] : {std::pair{0, 0.1}, std::pair{1, 1.0}}) {
    const TunedParameter& p = tuning.parameters[static_cast<std::size_t>(at)];
    EXPECT_TRUE(p.identifiable);
    const double deviation = std::log(p.upper / p.lower) / (2.0 * 1.96);
    EXPECT_NEAR(std::log(p.value / truth), 0.0, 5.0 * deviation) << p.name << " = " << p.value;
    EXPECT_NEAR(std::log(p.bootstrap_upper / p.bootstrap_lower) / std::log(p.upper / p.lower), 1.0, 0.5);
  }
  EXPECT_LT(tuning.estimate.decrement, 1e-6);
  EXPECT_LT(tuning.likelihood_ratio_p_value, 1e-10);
  EXPECT_FALSE(tuning.misspecified);
  EXPECT_NEAR(tuning.parameters[0].steps_for_10_percent / 2762.0, 1.0, 0.25);
}

TEST(Tuning, FindsTheSameFromEveryStart) {
  const auto runs = simulate(local_level(0.1, 1.0), 10, 300, 2);
  const Tuning best = tune_linear(local_level(0.1, 1.0), "diag(Q),diag(R)", runs);
  for (const double q : {1e-4, 1e-2, 10.0, 1e3}) {
    for (const double r : {1e-3, 0.1, 100.0}) {
      const Tuning tuning = tune_linear(local_level(q, r), "diag(Q),diag(R)", runs);
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(tuning.parameters[i].value / best.parameters[i].value, 1.0, 2e-3) << q << ", " << r;
      }
    }
  }
}

TEST(Tuning, SaysThatNothingIsKnownInsteadOfANumber) {
  // No process noise at all, one sensor, 50 samples: Q can only be bounded from above.
  const Tuning tuning =
      tune_linear(local_level(0.01, 1.0), "diag(Q)", simulate(local_level(0.0, 1.0), 1, 50, 4));
  EXPECT_FALSE(tuning.anything_known());
  EXPECT_FALSE(tuning.parameters.front().identifiable);
  EXPECT_TRUE(std::isnan(tuning.parameters.front().value));
  EXPECT_EQ(tuning.parameters.front().lower, 0.0);
  EXPECT_EQ(tuning.phi, tuning.start);
  EXPECT_THAT(tuning.notes, ::testing::Contains(::testing::HasSubstr("Nothing")));
}

// The bounds of a search are a factor 1e6 away from where it begins, which is no place for an optimum.
TEST(Tuning, DoesNotDependOnWhereTheSearchBegins) {
  const auto runs = simulate(local_level(0.1, 1.0), 10, 200, 2);
  const Tuning best = tune_linear(local_level(0.1, 1.0), "diag(Q),diag(R)", runs);
  for (const double q : {1e-13, 1e-9, 1e-7, 1e5, 1e8, 1e11}) {
    const Tuning tuning = tune_linear(local_level(q, 1.0), "diag(Q),diag(R)", runs);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_TRUE(tuning.parameters[i].identifiable) << q;
      EXPECT_NEAR(tuning.parameters[i].value / best.parameters[i].value, 1.0, 2e-3) << q;
      EXPECT_NEAR(tuning.parameters[i].upper / best.parameters[i].upper, 1.0, 1e-2) << q;
    }
  }
}

TEST(Tuning, BeginsAgainFromTheEndOfTheSearchAndGivesUpWithoutAValue) {
  const auto tuned = [](double a, double b, double c) {
    const testing::QuadraticScore score(Vector{{a, b, c}}, testing::some_curvature());
    return tune(score, Vector::Zero(3));
  };
  const auto expect_found = [](const Tuning& tuning, const Vector& top) {
    ASSERT_EQ(tuning.coordinates.size(), 3U);
    EXPECT_LT((tuning.phi - top).cwiseAbs().maxCoeff(), 1e-3) << tuning.phi.transpose();
    EXPECT_THAT(tuning.notes, ::testing::Not(::testing::Contains(::testing::HasSubstr("end of the search"))));
  };
  expect_found(tuned(1.0, -2.0, 13.0), Vector{{1.0, -2.0, 13.0}});
  expect_found(tuned(1.0, -2.0, 20.0), Vector{{1.0, -2.0, 20.0}});
  expect_found(tuned(1.0, -40.0, 1.0), Vector{{1.0, -40.0, 1.0}});
  for (const double side : {1.0, -1.0}) {
    const Tuning lost = tuned(1.0, -2.0, side * 70.0);  // beyond 4 ln 1e6 = 55.3
    EXPECT_FALSE(lost.anything_known());
    for (const TunedParameter& parameter : lost.parameters) {
      EXPECT_FALSE(parameter.identifiable) << parameter.name;
      EXPECT_TRUE(std::isnan(parameter.value) && std::isnan(parameter.lower)) << parameter.name;
      EXPECT_FALSE(parameter.reason.empty());
    }
    EXPECT_EQ(lost.phi, lost.start);
    EXPECT_EQ(lost.notes.back(),
              fmt::format("No value is given: for c the score still rises at the end of the search, 1e{}24 "
                          "times the present value.",
                          side > 0.0 ? '+' : '-'));
  }
}

/// A quadratic one that does not rise above −1, whatever its gradient says.
class CutScore final : public testing::QuadraticScore {
 public:
  using QuadraticScore::QuadraticScore;
  UnitScores scores(const Vector& phi, bool gradient) const override {
    UnitScores scores = QuadraticScore::scores(phi, gradient);
    scores.value[0] = std::min(scores.value[0], -1.0);
    return scores;
  }
};

TEST(Tuning, SaysWhetherTheSearchConverged) {
  const Vector top{{1.0, -2.0, 0.5}};
  const auto says_so = ::testing::Contains(::testing::StartsWith("The search did not converge"));
  const Tuning whole = tune(testing::QuadraticScore(top, testing::some_curvature()), Vector::Zero(3));
  EXPECT_TRUE(whole.converged);
  EXPECT_THAT(whole.notes, ::testing::Not(says_so));
  const Tuning cut = tune(CutScore(top, testing::some_curvature()), Vector::Zero(3));
  EXPECT_FALSE(cut.converged);
  EXPECT_THAT(cut.notes, says_so);
}

/// Of so many values of a normal law whose mean square is s the variance e^φ.
class VarianceScore final : public testing::QuadraticScore {
 public:
  VarianceScore(double values, double s)
      : QuadraticScore(Vector::Zero(1), Matrix::Constant(1, 1, 0.5 * values)), values_(values), s_(s) {}
  UnitScores scores(const Vector& phi, bool gradient) const override {
    UnitScores scores = QuadraticScore::scores(phi, gradient);
    scores.value[0] = -0.5 * values_ * (phi[0] + s_ * std::exp(-phi[0]));
    if (gradient) scores.gradient(0, 0) = -0.5 * values_ * (1.0 - s_ * std::exp(-phi[0]));
    return scores;
  }

 private:
  double values_, s_;
};

// n (φ − ln s + s e^−φ − 1) is twice the drop: of a variance known to a factor of 1.8 the normal interval of
// the logarithm is another one.
TEST(Tuning, WhatIsKnownWeaklyHasTheLimitsOfTheLikelihoodRatio) {
  const Tuning tuning = tune(VarianceScore(6.0, 4.0), Vector::Zero(1));
  const TunedParameter& p = tuning.parameters.front();
  ASSERT_TRUE(p.identifiable);
  EXPECT_TRUE(p.by_likelihood_ratio);
  EXPECT_NEAR(p.value, 4.0, 1e-3);
  for (const double limit : {p.lower, p.upper})
    EXPECT_NEAR(6.0 * (std::log(limit / 4.0) + 4.0 / limit - 1.0), 3.8415, 0.02) << limit;
  EXPECT_GT(p.upper, 1.2 * 4.0 * std::exp(1.96 / std::sqrt(3.0)));
  EXPECT_EQ(p.contradicts_present(), p.lower > 1.0);
  EXPECT_FALSE(tune(VarianceScore(60.0, 4.0), Vector::Zero(1)).parameters.front().by_likelihood_ratio);
}

TEST(Tuning, AnElementOfACholeskyFactorCountsTwiceInItsVariance) {
  const auto runs = simulate(local_level(0.01, 1.0), 20, 20, 3);
  const Tuning square = tune_linear(local_level(0.01, 1.0), "diag(Q),diag(R)", runs);
  const Tuning root = tune_linear(local_level(0.01, 1.0), "full(Q),full(R)", runs);
  ASSERT_TRUE(std::isfinite(square.parameters[0].upper));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(root.parameters[i].lower, square.parameters[i].lower, 0.01 * square.parameters[i].lower);
    EXPECT_NEAR(root.parameters[i].upper, square.parameters[i].upper, 0.01 * square.parameters[i].upper);
  }
}

TEST(Tuning, HoldsWhatOnlyACombinationShows) {
  // Two noises on the same state at every step are one.
  LinearModel model = local_level(0.5, 1.0);
  model.G = Matrix::Ones(1, 2);
  model.Q = 0.25 * Matrix::Identity(2, 2);
  const Tuning tuning = tune_linear(model, "diag(Q),diag(R)", simulate(model, 20, 200, 6));
  EXPECT_EQ(std::ranges::count(tuning.parameters, false, &TunedParameter::identifiable), 1);
  EXPECT_THAT(tuning.notes, ::testing::Contains(::testing::HasSubstr("combination of the others")));
  EXPECT_THAT(tuning.notes, ::testing::Contains(::testing::HasSubstr("with what is held as it is")));
}

TEST(Tuning, TakesTheSandwichWhereTheLawIsNotGaussian) {
  // Laplace noise of the right variance: the variance of its variance is 5, not 2.
  auto runs = simulate(local_level(1e-3, 1e-3), 200, 100, 9);
  std::mt19937_64 random(10);
  std::exponential_distribution<double> exponential;
  for (MeasuredRun& run : runs) {
    for (Index k = 0; k < run.z.cols(); ++k) {
      run.z(0, k) += (exponential(random) - exponential(random)) / std::sqrt(2.0);
    }
  }
  const Tuning tuning = tune_linear(local_level(1e-3, 1.0), "diag(R)", runs);
  EXPECT_TRUE(tuning.misspecified);
  EXPECT_NEAR(tuning.information_ratio, 2.5, 5.0 * 2.5 * std::sqrt(2.0 / 200.0));
  EXPECT_TRUE(tuning.by_sandwich);
  // The likelihood ratio is over the same factor.
  EXPECT_NEAR(tuning.likelihood_ratio_p_value,
              chi_square_survival(tuning.likelihood_ratio / tuning.information_ratio, 1.0), 1e-12);
  const Tuning right =
      tune_linear(local_level(1e-3, 1.0), "diag(R)", simulate(local_level(1e-3, 1.0), 200, 100, 9));
  EXPECT_FALSE(right.misspecified);
  EXPECT_FALSE(right.by_sandwich);
  EXPECT_NEAR(right.likelihood_ratio_p_value, chi_square_survival(right.likelihood_ratio, 1.0), 1e-12);
}

/// 200 units with information 100, and unit scores whose variance is `ratio` times that.
class ScatteredScore final : public testing::QuadraticScore {
 public:
  explicit ScatteredScore(double ratio, bool composite = false)
      : QuadraticScore(Vector::Constant(1, 0.5), Matrix::Constant(1, 1, 100.0)),
        ratio_(ratio),
        composite_(composite) {}
  Index units() const override { return kUnits; }
  UnitScores scores(const Vector& phi, bool gradient) const override {
    UnitScores scores = QuadraticScore::scores(phi, gradient);
    const double scatter = std::sqrt(100.0 * ratio_ / kUnits), slope = 100.0 * (0.5 - phi[0]) / kUnits;
    scores.value = Vector::Constant(kUnits, scores.value[0] / kUnits);
    scores.nis = scores.lag_one = Vector::Ones(kUnits);
    if (gradient) scores.gradient.resize(1, kUnits);
    for (Index i = 0; i < kUnits && gradient; ++i)
      scores.gradient(0, i) = slope + (i % 2 == 0 ? scatter : -scatter);
    scores.composite = composite_;
    return scores;
  }

 private:
  static constexpr Index kUnits = 200;
  double ratio_;
  bool composite_;
};

// The standard error of the variance is √(2/200) = 0.1.
TEST(Tuning, IntervalsAreWiderBeforeTheFilterIsCalledWrong) {
  const auto width = [](const Tuning& tuning) {
    return std::log(tuning.parameters[0].upper / tuning.parameters[0].lower) / (2.0 * 1.959964);
  };
  for (const auto& [ratio, by_sandwich, wrong] : {std::tuple(0.5, true, true),
                                                  {0.7, false, false},
                                                  {1.1, false, false},
                                                  {1.3, true, false},
                                                  {1.5, true, true}}) {
    const Tuning tuning = tune(ScatteredScore(ratio), Vector::Zero(1));
    EXPECT_NEAR(tuning.information_ratio, ratio, 1e-6);
    EXPECT_EQ(tuning.by_sandwich, by_sandwich) << ratio;
    EXPECT_EQ(tuning.misspecified, wrong) << ratio;
    EXPECT_NEAR(width(tuning), std::sqrt(by_sandwich ? 0.01 * ratio : 0.01), 1e-5) << ratio;
    const double over = by_sandwich ? std::max(1.0, ratio) : 1.0;
    EXPECT_NEAR(tuning.likelihood_ratio_p_value, chi_square_survival(25.0 / over, 1.0), 1e-9) << ratio;
  }
}

TEST(Tuning, SensorsThatAreScoredApartHaveTheSandwichAndNoVerdictOnTheFilter) {
  for (const double ratio : {1.0, 3.0}) {
    const Tuning tuning = tune(ScatteredScore(ratio, true), Vector::Zero(1));
    EXPECT_TRUE(tuning.by_sandwich);
    EXPECT_FALSE(tuning.misspecified);
    EXPECT_THAT(tuning.notes, ::testing::ElementsAre(::testing::HasSubstr("scored apart")));
  }
}

TEST(Tuning, WhatIsHeldAtItsLimitCountsAsMoved) {
  // No process noise where the filter has much: R alone is known, and Q is at most its limit.
  const Tuning tuning =
      tune_linear(local_level(1.0, 1.0), "diag(Q),diag(R)", simulate(local_level(0.0, 1.0), 5, 50, 4));
  const TunedParameter& q = tuning.parameters.front();
  ASSERT_FALSE(q.identifiable);
  EXPECT_LT(q.upper, 1.0);
  EXPECT_TRUE(q.contradicts_present());
  EXPECT_EQ(tuning.likelihood_ratio_dof, 2);
}

/// Chen's robot [Chen 2018]: a mass on a line driven by a known force, whose position is measured every 0.1 s
/// for 20 s. The force is known, so that it plays no part; Q is the density of the acceleration, R the
/// variance of the measurement.
TEST(Tuning, FindsTheNoiseOfChensRobotFromEveryStart) {
  const auto robot = [](double q, double r) {
    LinearModel model = survey_model();
    constexpr double T = 0.1;
    model.F << 1.0, T, 0.0, 1.0;
    model.G = Matrix::Identity(2, 2);
    model.Q << T * T * T / 3.0, T * T / 2.0, T * T / 2.0, T;
    model.Q *= q;
    model.H = Matrix(1, 2);
    model.H << 1.0, 0.0;
    model.R = r * Matrix::Identity(1, 1);
    model.P0 = Matrix::Identity(2, 2);
    return model;
  };
  const auto runs = simulate(robot(1.0, 0.1), 10, 200, 21);
  for (const double q : {0.1, 0.7, 5.0}) {
    for (const double r : {0.01, 0.1, 1.0}) {
      const Tuning tuning = tune_linear(robot(q, r), "Q,R", runs);
      for (const auto& [at, truth] : {std::pair{0, 1.0 / q}, std::pair{1, 0.1 / r}}) {
        const TunedParameter& p = tuning.parameters[static_cast<std::size_t>(at)];
        const double deviation = std::log(p.upper / p.lower) / (2.0 * 1.96);
        EXPECT_LT(deviation, 0.15);
        EXPECT_NEAR(std::log(p.value / truth), 0.0, 5.0 * deviation) << q << ", " << r << ": " << p.name;
      }
    }
  }
}

/// The information that each further step holds has the rank of the autocovariance least squares: what these
/// cannot tell, only the start of a run can.
TEST(Tuning, RankIsThatOfAutocovarianceLeastSquares) {
  // Two states of which one is measured: an ARMA(2, 2) with three numbers, for the four of full(Q) and R.
  LinearModel model = survey_model();
  model.F << 0.8, 1.0, 0.0, 0.5;
  model.H = Matrix(1, 2);
  model.H << 1.0, 0.0;
  model.R = Matrix::Identity(1, 1);
  model.Q = Matrix::Identity(2, 2);
  for (const auto& [free, rank] : {std::pair{"full(Q),R", 3}, {"diag(Q),R", 3}, {"Q,R", 2}}) {
    const NoiseParameters noise(model, parse_free_noise(free));
    const auto derivatives = noise.derivatives(noise.start());
    const testing::AutocovarianceLeastSquares least_squares(model, derivatives, 20);
    EXPECT_EQ(Eigen::ColPivHouseholderQR<Matrix>(least_squares.design()).rank(), rank) << free;
    const InnovationSensitivities filter(model, derivatives, 1000);
    const Matrix later = filter.expected_information(2000) - filter.expected_information(1000);
    Eigen::ColPivHouseholderQR<Matrix> qr(later);
    qr.setThreshold(1e-9);
    EXPECT_EQ(qr.rank(), rank) << free;
  }
}

TEST(Tuning, WarnsOfARidge) {
  // A level and a slowly fading disturbance, seen only as their sum.
  LinearModel model = survey_model();
  model.F = Vector{{1.0, 0.9}}.asDiagonal();
  model.H = Matrix::Ones(1, 2);
  model.Q = 0.1 * Matrix::Identity(2, 2);
  model.R = Matrix::Identity(1, 1);
  const Tuning tuning = tune_linear(model, "diag(Q)", simulate(model, 30, 1000, 12));
  EXPECT_EQ(tuning.coordinates.size(), 2u);
  EXPECT_LT(tuning.correlation(0, 1), -0.3);
  EXPECT_EQ(std::abs(tuning.correlation(0, 1)) >= kRidgeCorrelation, !tuning.notes.empty());
}

TEST(Tuning, AStartFarFromTheTruthIsNoError) {
  const auto runs = testing::simulate(testing::local_level(0.1, 1.0), 20, 200, 6);
  for (const auto& [q, r] : {std::pair{1e-9, 1e-9}, {1e-9, 1.0}}) {
    const LinearScore score({testing::local_level(q, r), parse_free_noise("diag(Q),diag(R)")}, runs);
    EXPECT_NO_THROW(tune(score, score.noise().start())) << q << ", " << r;
  }
}

}  // namespace
}  // namespace credence::internal
