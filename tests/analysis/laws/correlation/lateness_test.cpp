#include "analysis/laws/correlation/lateness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <random>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/correlation_whitening.h"

namespace credence::internal {
namespace {

/// A target of nearly constant velocity on a line and its Kalman filter, which is exact but for what is
/// asked.
struct Target {
  int delay = 0;        ///< steps, of the measurements
  int behind = 0;       ///< steps, of the truth that the errors are taken against
  double bias = 0.0;    ///< of the measurements
  double speed = 0.0;   ///< at the start, beside its law
  double spread = 1.0;  ///< standard deviation of the speed at the start
  double Q_scale = 1.0;
  int steps = 60;

  RunLateness run(std::mt19937_64& generator) const {
    std::normal_distribution<double> normal;
    const Matrix F{{1.0, 1.0}, {0.0, 1.0}}, unit{{1.0 / 3.0, 0.5}, {0.5, 1.0}};
    const double q = 0.01, r = 1.0;
    const Matrix L = Eigen::LLT<Matrix>(q * unit).matrixL();
    const auto noise = [&] { return Vector{{normal(generator), normal(generator)}}; };
    const Vector mean{{0.0, speed}}, initial{{1.0, spread}};
    Vector x = mean + initial.cwiseProduct(noise()), estimate = mean;
    Matrix P = initial.cwiseAbs2().asDiagonal();
    std::deque<double> line;
    std::deque<Vector> truths;
    RunLateness sums;
    CorrelationWhitening whitening;
    Vector u, b;
    for (int k = 0; k < steps; ++k) {
      x = F * x + L * noise();
      const Vector last = estimate;
      estimate = F * estimate;
      P = F * P * F.transpose() + Q_scale * q * unit;
      truths.push_back(x);
      if (std::ssize(truths) > behind + 1) truths.pop_front();
      line.push_back(x[0] + bias + std::sqrt(r) * normal(generator));
      if (std::ssize(line) > delay) {
        const double S = P(0, 0) + r;
        const Vector K = P.col(0) / S;
        estimate += K * (line.front() - estimate[0]);
        P = (P - S * K * K.transpose()).eval();
        line.pop_front();
      }
      if (k == 0 || k < behind) continue;
      EXPECT_TRUE(whitening.compute(P));
      whitening.whiten(estimate - truths.front(), u);
      whitening.whiten(estimate - last, b);
      sums.add(u, b);
    }
    return sums;
  }

  LatenessTest study(int runs, std::mt19937_64& generator) const {
    LatenessSums sums;
    for (int i = 0; i < runs; ++i) run(generator).add_to(sums);
    return test_lateness(sums);
  }
};

// 1,500 studies of an exact filter: a p-value below α as often as α, by five standard errors.
TEST(Lateness, AnExactFilterIsCalledLateAsOftenAsTheLevelSays) {
  constexpr int kStudies = 1500;
  for (const int runs : {10, 30}) {
    std::mt19937_64 generator(static_cast<unsigned>(runs));
    int below_20 = 0, below_5 = 0, ahead_below_5 = 0;
    for (int i = 0; i < kStudies; ++i) {
      const LatenessTest test = Target{.steps = 20}.study(runs, generator);
      ASSERT_TRUE(test.reason.empty()) << test.reason;
      EXPECT_NEAR(test.p_value + test.ahead_p_value, 1.0, 1e-12);
      below_20 += test.p_value <= 0.2 ? 1 : 0;
      below_5 += test.p_value <= 0.05 ? 1 : 0;
      ahead_below_5 += test.ahead_p_value <= 0.05 ? 1 : 0;
    }
    const auto near = [&](int count, double level) {
      const double off = 5.0 * std::sqrt(level * (1.0 - level) / kStudies);
      EXPECT_NEAR(count / static_cast<double>(kStudies), level, off) << runs << " runs";
    };
    near(below_20, 0.2);
    near(below_5, 0.05);
    near(ahead_below_5, 0.05);
  }
}

TEST(Lateness, SaysHowManySteps) {
  std::mt19937_64 generator(3);
  for (const int delay : {1, 2, 4}) {
    const LatenessTest test = Target{.delay = delay}.study(60, generator);
    EXPECT_LT(test.p_value, 1e-4) << delay;
    EXPECT_NEAR(test.steps, delay, 0.15 * delay);
    EXPECT_GT(test.explained, 0.85) << delay;
  }
}

TEST(Lateness, SaysHowFarTheTruthIsBehind) {
  std::mt19937_64 generator(8);
  for (const int behind : {1, 2, 4}) {
    const LatenessTest test = Target{.behind = behind}.study(60, generator);
    EXPECT_LT(test.ahead_p_value, 1e-4) << behind;
    EXPECT_NEAR(test.steps, -behind, 0.15 * behind);
    EXPECT_GT(test.explained, 0.85) << behind;
    EXPECT_TRUE(std::isnan(Target{.behind = behind}.study(9, generator).ahead_p_value));
  }
}

// A filter that lags since its gain is too small is late, too, but not by the way of a time.
TEST(Lateness, AGainTooSmallExplainsLittle) {
  std::mt19937_64 generator(4);
  EXPECT_LT((Target{.Q_scale = 0.05}.study(60, generator).explained), 0.5);
}

TEST(Lateness, ABiasIsNone) {
  std::mt19937_64 generator(5);
  const LatenessTest still = Target{.bias = -2.0}.study(60, generator);
  EXPECT_GT(still.p_value, 1e-4);
  // Back along a motion that is nearly the same in all runs: nothing tells it from a delay.
  const Target same{.bias = -2.0, .speed = 30.0, .spread = 0.1};
  EXPECT_EQ(same.study(60, generator).reason, "the motion is always the same");
}

/// Errors that are autoregressions upon one that stays, beside a way that turns.
struct TurningRun {
  double delay = 0.0;  ///< steps
  double memory = 0.95;
  double stays = 1.0;  ///< standard deviation of the error that stays
  int steps = 500;

  void add_to(LatenessSums& sums, std::mt19937_64& generator) const {
    std::normal_distribution<double> normal;
    const auto noise = [&] { return Vector{{normal(generator), normal(generator)}}; };
    const Vector constant = stays * noise();
    const double phase = 6.3 * normal(generator);
    Vector error = noise();
    RunLateness run;
    for (int k = 0; k < steps; ++k) {
      error = memory * error + std::sqrt(1.0 - memory * memory) * noise();
      const double heading = 2.0 * std::sin(0.05 * k + phase);
      const Vector motion{{std::cos(heading), std::sin(heading)}};
      run.add(constant + error - delay * motion, motion);
    }
    run.add_to(sums);
  }

  LatenessTest study(int runs, std::mt19937_64& generator) const {
    LatenessSums sums;
    for (int i = 0; i < runs; ++i) add_to(sums, generator);
    return test_lateness(sums);
  }
};

// Of one and two runs the stretches are tested, which may hold less than the level, of more the runs, to five
// standard errors of 400 studies.
TEST(Lateness, OfFewRunsErrorsThatHaveNothingToDoWithTheWayAreLateAsOftenAsTheLevelSays) {
  constexpr int kStudies = 400;
  for (const int runs : {1, 2, 3, 5, 9}) {
    for (const double memory : {0.5, 0.95}) {
      std::mt19937_64 generator(static_cast<unsigned>(40 + runs));
      int below_5 = 0, below_1 = 0;
      for (int i = 0; i < kStudies; ++i) {
        const LatenessTest test = TurningRun{.memory = memory, .steps = 200}.study(runs, generator);
        ASSERT_TRUE(test.reason.empty()) << test.reason;
        below_5 += test.p_value <= 0.05 ? 1 : 0;
        below_1 += test.p_value <= 0.01 ? 1 : 0;
      }
      EXPECT_LE(below_5, 20 + 5 * std::sqrt(19.0)) << runs << " runs, memory " << memory;
      EXPECT_LE(below_1, 4 + 5 * std::sqrt(4.0)) << runs << " runs, memory " << memory;
      EXPECT_GT(below_5, 0) << runs << " runs, memory " << memory;
    }
  }
}

TEST(Lateness, OneRunThatTurnsTellsTheDelay) {
  std::mt19937_64 generator(6);
  for (const int runs : {1, 2, 3, 9}) {
    const LatenessTest test = TurningRun{.delay = 3.0, .memory = 0.5}.study(runs, generator);
    EXPECT_LT(test.p_value, 3e-3) << runs << " runs";
    EXPECT_NEAR(test.steps, 3.0, 0.6) << runs << " runs";
    EXPECT_GT((TurningRun{.delay = -3.0, .memory = 0.5}.study(runs, generator).p_value), 0.9);
  }
}

// Of 20,000 steps the groups are joined by twos, and stretches are what they were.
TEST(Lateness, ALongRunIsTenStretchesToo) {
  std::mt19937_64 generator(8);
  LatenessSums sums;
  TurningRun{.delay = 1.0, .memory = 0.5, .steps = 20000}.add_to(sums, generator);
  EXPECT_EQ(sums.stretch_slopes.count, 10);
  EXPECT_NEAR(sums.stretch_slopes.mean, 1.0, 5.0 * std::sqrt(3.0 / 10000.0));
  EXPECT_NEAR(sums.run_slopes.mean, sums.stretch_slopes.mean, 0.1);
}

TEST(Lateness, AWayThatNeverTurnsOrIsTooShortTellsNothing) {
  std::mt19937_64 generator(6);
  EXPECT_EQ(test_lateness({}).reason, "no estimates are known beside the errors");
  const LatenessTest brief = TurningRun{.steps = 49}.study(2, generator);
  EXPECT_FALSE(brief.reason.empty());
  EXPECT_TRUE(std::isnan(brief.p_value));
  RunLateness straight;
  for (int k = 0; k < 100; ++k) straight.add(Vector::Ones(1), Vector::Ones(1));
  LatenessSums sums;
  for (int i = 0; i < 5; ++i) straight.add_to(sums);
  EXPECT_EQ(test_lateness(sums).reason, kNoVariedMotion);
}

TEST(Lateness, MergesToTheWholeAndLeavesOutWhatDoesNotFit) {
  std::mt19937_64 generator(7);
  LatenessSums a, b, whole, merged, none;
  for (int i = 0; i < 12; ++i) {
    const RunLateness run = Target{.steps = 5}.run(generator);
    run.add_to(i < 6 ? a : b);
    run.add_to(whole);
  }
  merged.merge(a);
  merged.merge(b);
  merged.merge(none);
  EXPECT_NEAR(test_lateness(merged).steps, test_lateness(whole).steps, 1e-12);
  RunLateness other;
  other.add(Vector::Ones(1), Vector::Ones(1));
  LatenessSums of_one;
  other.add_to(of_one);
  merged.merge(of_one);
  other.add_to(merged);
  EXPECT_EQ(merged.runs.count, 12);
  EXPECT_EQ(merged.run_slopes.count, whole.run_slopes.count);
}

}  // namespace
}  // namespace credence::internal
