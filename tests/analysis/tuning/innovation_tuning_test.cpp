#include "analysis/tuning/innovation_tuning.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace credence::internal {
namespace {

/// Scalar innovations of a filter with S = 1: an autoregression of this variance and lag-one correlation.
SensorRecord record(Index runs, Index steps, double variance, double lag_one, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  SensorRecord all;
  for (Index i = 0; i < runs; ++i) {
    RecordedInnovations& run = all.runs.emplace_back();
    run.dof = 1.0;
    double nu = std::sqrt(variance) * normal(random);
    for (Index k = 0; k < steps; ++k) {
      run.nis.push_back(nu * nu);
      run.whitened.emplace_back(Vector::Constant(1, nu));
      nu = lag_one * nu + std::sqrt(variance * (1.0 - lag_one * lag_one)) * normal(random);
    }
  }
  return all;
}

TEST(InnovationTuning, FindsTheScaleOfS) {
  const InnovationTuning t = tune_innovations(record(40, 100, 2.0, 0.0, 3), 0.95);
  EXPECT_NEAR(t.scale.scale, 2.0, 5.0 * 2.0 * std::sqrt(2.0 / 4000.0));
  EXPECT_LT(t.scale.lower, 2.0);
  EXPECT_GT(t.scale.upper, 2.0);
  EXPECT_EQ(t.gain, GainError::none_seen);
  EXPECT_LT(t.likelihood_ratio_p_value, 1e-50);
  // ln of the ratio of densities a step: ½ (s − 1 − ln s).
  EXPECT_NEAR(t.score_after - t.score_before, 0.5 * (t.scale.scale - 1.0 - std::log(t.scale.scale)), 1e-12);
  // A variance is known to 10 % by 200 values.
  EXPECT_NEAR(t.steps_for_10_percent / 200.0, 1.0, 0.5);
  EXPECT_EQ(t.left_out_parts.verdict, Verdict::consistent);
  EXPECT_EQ(t.left_out_parts.parts, 40);
  EXPECT_TRUE(t.left_out_parts.of_runs);
}

TEST(InnovationTuning, TellsToWhichSideTheGainIsWrong) {
  const InnovationTuning lingering = tune_innovations(record(10, 400, 1.0, 0.3, 4), 0.95);
  EXPECT_EQ(lingering.gain, GainError::too_small);
  EXPECT_NEAR(lingering.lag_one, 0.3, 5.0 / std::sqrt(4000.0));
  EXPECT_TRUE(std::isnan(lingering.likelihood_ratio_p_value));
  EXPECT_EQ(tune_innovations(record(10, 400, 1.0, -0.3, 4), 0.95).gain, GainError::too_large);
}

TEST(InnovationTuning, WhatNoNoiseMendsComesFirst) {
  using ::testing::Contains;
  using ::testing::HasSubstr;
  using ::testing::Not;
  SensorRecord lingering = record(20, 200, 1.0, 0.3, 4);
  EXPECT_EQ(tune_innovations(lingering, 0.95).comes_first, "") << "correlation alone is neither";
  EXPECT_THAT(tune_innovations(lingering, 0.95).notes, Contains(HasSubstr("Q over R should be larger")));
  lingering.unwrapped = 3;
  const InnovationTuning turned = tune_innovations(lingering, 0.95);
  EXPECT_THAT(turned.comes_first, HasSubstr("3 innovations of an angle lie beyond half a turn"));
  EXPECT_THAT(turned.notes, Contains(HasSubstr("First: 3 innovations of an angle")));
  EXPECT_THAT(turned.notes, Not(Contains(HasSubstr("Q over R"))));

  SensorRecord unmarked = record(20, 200, 0.01, 0.0, 5);
  for (const double nu : {6.2, 6.3, -6.35})
    add_turns(Vector::Constant(1, nu), Vector::Constant(1, 0.01), 1, {}, unmarked.turns);
  EXPECT_THAT(tune_innovations(unmarked, 0.95).comes_first,
              HasSubstr("3 values of the innovation are a whole turn of 2π off"));

  SensorRecord late = record(20, 200, 1.0, 0.0, 5);
  for (RecordedInnovations& run : late.runs) {
    for (Vector& u : run.whitened) u[0] += 0.6;
  }
  const InnovationTuning biased = tune_innovations(late, 0.95);
  EXPECT_EQ(biased.gain, GainError::too_small) << "a mean is a correlation at every lag";
  EXPECT_THAT(biased.comes_first, HasSubstr("the innovations have mean 0.6"));
  EXPECT_THAT(biased.notes, Not(Contains(HasSubstr("Q over R"))));
}

// A mean that is not there is found in at most 5 % of all records; 5 standard errors. Of short runs that are
// correlated over all of their length, too.
TEST(InnovationTuning, HardlyAnythingComesFirstWhereNoMeanIs) {
  constexpr int kRecords = 400;  // of fewer a tenth would pass
  for (const double correlation : {0.0, 0.9, 0.98}) {
    int found = 0;
    for (std::uint64_t seed = 0; seed < kRecords; ++seed) {
      const InnovationTuning t = tune_innovations(record(40, 60, 1.0, correlation, 100 + seed), 0.95);
      found += t.comes_first.empty() ? 0 : 1;
      if (correlation > 0.0) EXPECT_FALSE(t.left_out_parts.tested) << "which needs white innovations";
    }
    EXPECT_LE(found, 0.05 * kRecords + 5 * std::sqrt(0.05 * 0.95 * kRecords)) << correlation;
  }
}

TEST(InnovationTuning, SaysThatQAndRCannotBeSeparated) {
  const InnovationTuning t = tune_innovations(record(1, 100, 1.0, 0.0, 5), 0.95);
  EXPECT_THAT(t.notes, ::testing::Contains(::testing::HasSubstr("Q and R cannot be separated")));
  EXPECT_THAT(t.notes, ::testing::Contains(::testing::HasSubstr("credence.tune_filter")));
  EXPECT_FALSE(t.left_out_parts.of_runs);
}

TEST(InnovationTuning, AnotherScaleInOneRunIsRejected) {
  SensorRecord runs = record(40, 300, 1.0, 0.0, 6);
  for (double& nis : runs.runs[3].nis) nis *= 2.0;
  const InnovationTuning t = tune_innovations(runs, 0.95);
  EXPECT_EQ(t.left_out_parts.verdict, Verdict::optimistic);
  EXPECT_EQ(t.left_out_parts.rejected, 1);
}

// A sensor that is off and logged as zero; or speaks in one of its runs alone.
/// Student's t with four degrees of freedom, of variance one.
SensorRecord heavy_tailed(Index runs, Index steps, std::uint64_t seed) {
  SensorRecord all = record(runs, steps, 1.0, 0.0, seed);
  std::mt19937_64 random(seed + 1);
  std::student_t_distribution<double> student(4.0);
  for (RecordedInnovations& run : all.runs) {
    for (std::size_t k = 0; k < run.nis.size(); ++k) {
      const double nu = student(random) / std::sqrt(2.0);
      run.nis[k] = nu * nu;
      run.whitened[k] = Vector::Constant(1, nu);
    }
  }
  return all;
}

// By the χ² law 335 of 424 such records were rejected.
TEST(InnovationTuning, HeavyTailsAreNoOtherScale) {
  constexpr int kRecords = 200;
  int rejected = 0;
  for (std::uint64_t seed = 0; seed < kRecords; ++seed) {
    const InnovationTuning t = tune_innovations(heavy_tailed(20, 50, 100 + 2 * seed), 0.95);
    rejected += t.left_out_parts.tested && t.left_out_parts.verdict != Verdict::consistent;
  }
  EXPECT_LE(rejected, kRecords * 0.25) << "of 0.79";
}

TEST(InnovationTuning, ASensorOfManyIsTestedAtItsShareOfTheLevel) {
  int alone = 0, of_eight = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const SensorRecord one = record(10, 60, 1.0, 0.0, 1000 + seed);
    alone += tune_innovations(one, 0.95).gain != GainError::none_seen;
    of_eight += tune_innovations(one, 0.95, 8).gain != GainError::none_seen;
  }
  const double share = 0.05 / 8.0;
  EXPECT_LE(of_eight, 400 * (share + 5.0 * std::sqrt(share / 400.0)));
  EXPECT_GT(alone, of_eight);
}

// Stretches of a run say that the size of what stays in it is well known: 50 % of such intervals missed.
TEST(InnovationTuning, WhatStaysInFewRunsHasNoInterval) {
  constexpr int kRecords = 100;
  int missed = 0, none = 0;
  for (int i = 0; i < kRecords; ++i) {
    SensorRecord staying = record(3, 300, 0.7, 0.0, 3000 + static_cast<std::uint64_t>(i));
    std::mt19937_64 random(static_cast<std::uint64_t>(i));
    std::normal_distribution<double> normal(0.0, std::sqrt(0.3));
    for (RecordedInnovations& run : staying.runs) {
      const double bias = normal(random);
      for (std::size_t k = 0; k < run.nis.size(); ++k) {
        const double nu = run.whitened[k][0] + bias;
        run.nis[k] = nu * nu;
        run.whitened[k][0] = nu;
      }
    }
    const InnovationTuning t = tune_innovations(staying, 0.95);
    if (!t.comes_first.empty()) continue;
    none += std::isnan(t.scale.lower);
    missed += t.scale.lower > 1.0 || t.scale.upper < 1.0;
    if (std::isnan(t.scale.lower)) EXPECT_THAT(t.scale.reason, ::testing::HasSubstr("stays in whole runs"));
  }
  EXPECT_GT(none, 30);
  EXPECT_LE(missed, 15);
}

TEST(InnovationTuning, InnovationsThatAreZeroTellNothing) {
  SensorRecord off = record(3, 50, 1.0, 0.0, 7);
  for (std::size_t run = 1; run < 3; ++run) std::ranges::fill(off.runs[run].nis, 0.0);
  EXPECT_FALSE(tune_innovations(off, 0.95).left_out_parts.tested);
  for (RecordedInnovations& run : off.runs) {
    std::ranges::fill(run.nis, 0.0);
    for (Vector& u : run.whitened) u.setZero();
  }
  const InnovationTuning t = tune_innovations(off, 0.95);
  EXPECT_THAT(t.comes_first, ::testing::StartsWith("every innovation is exactly zero"));
  EXPECT_TRUE(std::isnan(t.score_after) && std::isnan(t.likelihood_ratio_p_value));
  EXPECT_FALSE(t.left_out_parts.tested);
}

TEST(InnovationTuning, RefusesAnEmptyRecord) {
  EXPECT_THROW(tune_innovations({}, 0.95), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
