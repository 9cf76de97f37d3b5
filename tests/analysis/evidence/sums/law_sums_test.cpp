#include "analysis/evidence/sums/law_sums.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace credence::internal {
namespace {

/// A run whose whitened errors are these, of uncorrelated states of variances 4.
RunLaw run_of(const std::vector<Vector>& whitened) {
  RunLaw run;
  for (const Vector& u : whitened) {
    const Vector variance = Vector::Constant(u.size(), 4.0);
    if (run.add_error(2.0 * u, variance)) run.add_whitened(u, variance.asDiagonal());
  }
  return run;
}

LawSums sums_of(const std::vector<Vector>& whitened, const std::string& block = "") {
  LawSums sums;
  run_of(whitened).add_to(sums, block);
  return sums;
}

TEST(LawSums, AverageTheOuterProductsOfARun) {
  const LawSums sums = sums_of({Vector{{1.0, 2.0}}, Vector{{-3.0, 1.0}}});
  ASSERT_EQ(sums.second_moments.dim(), 2);
  EXPECT_EQ(sums.second_moments.runs(), 1);
  // A = ½ [1 + 9, 2 − 3; 2 − 3, 4 + 1].
  const auto directions = second_moment_directions(2);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const SecondMomentDirection& along = directions[i];
    const double diagonal[] = {5.0, 2.5};
    const double expected =
        along.sign == 0 ? diagonal[along.p] : 0.5 * (diagonal[0] + diagonal[1]) - 0.5 * along.sign;
    EXPECT_NEAR(sums.second_moments.along()[i].mean, expected, 1e-14) << i;
  }
  EXPECT_NEAR(sums.error_means.mean[0], -1.0, 1e-15);
  EXPECT_NEAR(sums.error_means.mean[1], 1.5, 1e-15);
}

// One component that keeps its sign for half a run has no mean over it, and is as large in each tenth of it.
TEST(LawSums, AnErrorThatLastsForATenthOfARunIsNoErrorOfAllOfIt) {
  std::vector<Vector> slow, fast;
  for (int k = 0; k < 320; ++k) {
    const double sign = k % 2 == 0 ? 1.0 : -1.0;
    slow.push_back(Vector{{sign, k < 160 ? 1.0 : -1.0}});
    fast.push_back(Vector{{sign, k % 4 < 2 ? 1.0 : -1.0}});
  }
  const LawSums sums = sums_of(slow);
  ASSERT_EQ(sums.stretches.means.count, 10);
  EXPECT_NEAR(sums.whitened_means.mean.norm(), 0.0, 1e-12);
  EXPECT_NEAR(sums.stretches.means.scatter(1, 1), 10.0, 1e-9);
  EXPECT_NEAR(sums.stretches.means.scatter(0, 0), 0.0, 1e-9);
  EXPECT_FALSE(sums.errors_stand());
  EXPECT_FALSE(sums.stretches.stay());
  EXPECT_TRUE(sums.stretches.stand(320.0));
  EXPECT_FALSE(sums.stretches.stand(2.0)) << "chance may do it";
  EXPECT_FALSE(sums_of(fast).stretches.stand(320.0));
  const LawSums constant = sums_of(std::vector<Vector>(320, Vector{{1.0, 2.0}}));
  EXPECT_TRUE(constant.errors_stand());
  EXPECT_TRUE(constant.stretches.stay());
  EXPECT_EQ(sums_of({slow.begin(), slow.begin() + 9}).stretches.means.count, 0);
}

/// The stretches of a run of errors that are alternately positive and negative, and one that keeps its sign
/// for half the run, the last of `states`.
StretchSums stretches_of_large(Index states, Index rows) {
  RunLaw run;
  for (Index k = 0; k < rows; ++k) {
    Vector u = Vector::Constant(states, k % 2 == 0 ? 1.0 : -1.0);
    u[states - 1] = 2 * k < rows ? 3.0 : -3.0;
    run.large.add_each(u, 32);
  }
  LawSums sums;
  run.add_to(sums, "first block");
  return sums.stretches;
}

TEST(StretchSums, OfALargeStateAreOfAllOfIt) {
  const StretchSums stretches = stretches_of_large(21, 640);
  EXPECT_EQ(stretches.runs, 1);
  EXPECT_EQ(stretches.means.count, 10);
  EXPECT_NEAR(stretches.square(20, 20), 9.0, 1e-12);
  EXPECT_NEAR(stretches.square(5, 3), 1.0, 1e-12);
  EXPECT_NEAR(stretches.means.scatter(20, 20), 90.0, 1e-9);
  EXPECT_TRUE(stretches.stand(640.0));
}

/// Sums of runs of errors √share b + √(1 − share) w, b the same all along a run, w with a memory.
StretchSums sums_with_offset(unsigned seed, int runs, Index states, double share, double memory) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vector(Vector::NullaryExpr(states, [&] { return normal(random); })); };
  LawSums sums;
  for (int i = 0; i < runs; ++i) {
    const Vector offset = draw();
    Vector w = draw();
    std::vector<Vector> errors;
    for (int k = 0; k < 500; ++k) {
      w = memory * w + std::sqrt(1.0 - memory * memory) * draw();
      errors.emplace_back(std::sqrt(share) * offset + std::sqrt(1.0 - share) * w);
    }
    LawSums of_run = sums_of(errors);
    sums.merge(of_run);
  }
  return sums.stretches;
}

// A bias that P holds is a part of every error of a run, and of far fewer values than its rows: of 0.3 of the
// variance it moves the mean of four runs by 0.21, and their 400 independent rows by 0.07. What is forgotten
// is seldom taken for one.
TEST(StretchSums, SeeAPartOfTheErrorsThatStays) {
  constexpr int kStudies = 60;
  for (const int runs : {1, 2, 4, 10}) {
    for (const Index states : {1, 3}) {
      int stay = 0, forgotten = 0;
      const double rows = 500.0 * runs / 5.0;
      for (unsigned seed = 0; seed < kStudies; ++seed) {
        stay += sums_with_offset(seed, runs, states, 0.3, 0.8).persist(rows);
        forgotten += sums_with_offset(seed, runs, states, 0.0, 0.8).persist(rows);
      }
      EXPECT_GE(stay, runs == 1 ? 30 : 42) << runs << ' ' << states;
      EXPECT_LE(forgotten, 6) << runs << ' ' << states;
    }
  }
}

// Rows taken of a long run stand for those about them.
TEST(RunWhitened, OfALongRunTakesRowsEvenly) {
  for (const Index of_group : {1, 8, 32}) {
    RunWhitened each, taken;
    Index rows = 0;
    for (Index k = 0; k < 10'000; ++k) {
      const Vector u{{k < 5000 ? 1.0 : 3.0, 1.0}};
      each.add_each(u, of_group);
      const bool takes = taken.takes(of_group);
      rows += takes ? 1 : 0;
      if (takes) {
        taken.add(u, of_group);
      } else {
        taken.skip();
      }
    }
    // 64 groups of each size but the first, one for each doubling of the run, are half seen.
    EXPECT_GE(rows, 32 * of_group);
    EXPECT_LE(rows, 64 * 9 * of_group);
    EXPECT_LT(rows, 5'000);
    for (const RunWhitened& run : {each, taken}) {
      EXPECT_EQ(run.sums.rows(), 10'000);
      const auto squared = static_cast<double>(run.squared);
      EXPECT_NEAR(squared, 10'000.0, 256.0);
      EXPECT_NEAR(run.outer(0, 0) / squared, 5.0, 0.25);
      EXPECT_NEAR(run.outer(1, 0) / squared, 2.0, 0.1);
      EXPECT_EQ(run.outer(1, 1), squared) << "the mean square of what is always one is one";
    }
    EXPECT_NEAR(taken.mean()[0], 2.0, 0.1);
    EXPECT_EQ(taken.mean()[1], 1.0);
    Vector sum = Vector::Zero(2);
    for (Index g = 0; g < each.sums.groups(); ++g) sum += each.sums.of_group(g);
    EXPECT_EQ(sum, (Vector{{20'000.0, 10'000.0}}));
  }
}

// Row k of a run is √(k + 1) e, so that a stretch has the mean of its k + 1; the last group is not full.
TEST(StretchMoments, AreOfTheSquaresOfEqualStretches) {
  RunWhitened run{.by_group = true};
  for (Index k = 0; k < 1290; ++k) run.add(std::sqrt(static_cast<double>(k + 1)) * Vector{{1.0, -1.0}}, 64);
  ASSERT_EQ(run.sums.rows_of_group(), 32);  // 40 groups and a part
  StretchMoments stretches;
  stretches.add(run);
  const SecondMoments twentieths = stretches.of_runs(1);
  ASSERT_EQ(twentieths.runs(), 20);
  EXPECT_NEAR(mean_of(twentieths)(0, 0), 640.5, 1e-9);
  EXPECT_NEAR(mean_of(twentieths)(1, 0), -640.5, 1e-9);
  // Means 32.5, 96.5, …: variance 64² · 35 of twenty.
  EXPECT_NEAR(twentieths.along().front().variance(), 64.0 * 64.0 * 35.0, 1e-6);
  EXPECT_EQ(stretches.of_runs(2).runs(), 0) << "a run is missing";
  stretches.merge(StretchMoments(stretches));
  EXPECT_EQ(stretches.of_runs(2).runs(), 20);  // ten of each
  EXPECT_EQ(stretches.of_runs(20).runs(), 0);
  EXPECT_EQ(StretchMoments{}.of_runs(0).runs(), 0);
}

// Of 300 rows of a few states all are whitened; of more states the first 64, every second to 128, every
// fourth to 256, every eighth from there on.
TEST(RunLaw, WhitensSomeRowsOfALongRun) {
  for (const auto& [states, few, rows] :
       {std::tuple{6, false, 300}, {7, false, 64 + 32 + 32 + 5}, {7, true, 300}}) {
    RunLaw run{.few = few};
    int whitened = 0;
    for (int k = 0; k < 300; ++k) {
      const Vector e = Vector::Ones(states);
      if (!run.add_error(e, e)) continue;
      run.add_whitened(e, Matrix::Identity(states, states));
      ++whitened;
    }
    EXPECT_EQ(whitened, rows) << states;
    LawSums sums;
    run.add_to(sums, "");
    EXPECT_EQ(sums.error_means.mean, Vector::Ones(states)) << "of all rows";
    EXPECT_EQ(mean_of(sums.second_moments), Matrix::Ones(states, states));
  }
}

TEST(RunLaw, KnowsWhichStatesPClaimsToBeCorrelated) {
  RunLaw run;
  Matrix P = Vector{{1.0, 100.0, 4.0}}.asDiagonal();
  const Vector one = Vector::Ones(3);
  const auto add = [&] {
    ASSERT_TRUE(run.add_error(one, P.diagonal()));
    run.add_whitened(one, P);
  };
  P(2, 0) = 1e-10;  // rounding
  add();
  EXPECT_EQ(run.correlated, (std::vector<bool>{false, false, false}));
  P(2, 1) = 1.0;
  add();
  P(2, 1) = 0.0;
  add();
  EXPECT_EQ(run.correlated, (std::vector<bool>{false, false, true})) << "at some step";
  LawSums state, block;
  run.add_to(state, "");
  run.add_to(block, "first");
  EXPECT_EQ(state.correlated, run.correlated);
  EXPECT_TRUE(block.correlated.empty());
}

TEST(StretchSums, AddUpOverRunsOfTheLargestState) {
  StretchSums rising = stretches_of_large(13, 640), falling = stretches_of_large(21, 640);
  rising.merge(stretches_of_large(21, 640));
  falling.merge(stretches_of_large(13, 640));
  falling.merge({});
  for (const StretchSums& sums : {rising, falling}) {
    EXPECT_EQ(sums.runs, 1);
    EXPECT_EQ(sums.square.rows(), 21);
    EXPECT_EQ(sums.means.count, 10);
  }
  rising.merge(stretches_of_large(21, 320));
  EXPECT_EQ(rising.runs, 2);
  EXPECT_EQ(rising.means.count, 20);
  EXPECT_NEAR(rising.square(20, 20), 18.0, 1e-12);
}

TEST(LawSums, NormaliseAnErrorByItsOwnDeviation) {
  RunLaw run;
  ASSERT_TRUE(run.add_error(Vector{{3.0, -8.0}}, Vector{{9.0, 16.0}}));
  run.add_whitened(Vector{{1.0, 1.0}}, Vector{{9.0, 16.0}}.asDiagonal());
  LawSums sums;
  run.add_to(sums, "");
  EXPECT_EQ(sums.error_means.mean, (Vector{{1.0, -2.0}}));
}

TEST(LawSums, KeepTheStatesThatARunBeganWith) {
  RunLaw run = run_of({Vector{{1.0, 2.0}}});
  EXPECT_FALSE(run.add_error(Vector::Ones(3), Vector::Ones(3)));
  EXPECT_EQ(run.averaged.sums.rows(), 1);
  LawSums sums;
  run.add_to(sums, "");
  EXPECT_EQ(sums.error_means.mean, (Vector{{1.0, 2.0}}));
}

TEST(LawSums, TakeWhatHasMostStatesWhateverComesFirst) {
  const LawSums two = sums_of({Vector{{1.0, 2.0}}}), three = sums_of({Vector{{1.0, 2.0, 3.0}}});
  LawSums rising = two, falling = three;
  rising.merge(three);
  falling.merge(two);
  for (const LawSums& sums : {rising, falling}) {
    EXPECT_EQ(sums.second_moments.dim(), 3);
    EXPECT_EQ(sums.second_moments.runs(), 1);
    EXPECT_EQ(sums.error_means.count, 1);
    EXPECT_EQ(sums.error_means.mean, (Vector{{1.0, 2.0, 3.0}}));
  }
}

TEST(LawSums, OfTwoBlocksOfASizeTakeTheFirstByName) {
  const LawSums arm = sums_of({Vector{{1.0, 2.0}}}, "arm"), leg = sums_of({Vector{{3.0, 4.0}}}, "leg");
  LawSums one = arm, other = leg;
  one.merge(leg);
  other.merge(arm);
  for (const LawSums& sums : {one, other}) {
    EXPECT_EQ(sums.averaged, "arm");
    EXPECT_EQ(sums.error_means.count, 1);
    EXPECT_EQ(sums.error_means.mean, (Vector{{1.0, 2.0}}));
  }
  LawSums empty;
  empty.merge(leg);
  EXPECT_EQ(empty.averaged, "leg");
  empty.merge(leg);
  EXPECT_EQ(empty.error_means.count, 2);
}

TEST(LawSums, OfWhitenedErrorsTakeThoseWithMostStates) {
  LawSums sums;
  sums.add_whitened(4, Vector::Ones(2));
  sums.add_whitened(4, Vector::Ones(3));
  sums.add_whitened(4, Vector::Zero(2));
  sums.add_whitened(8, Vector::Ones(1));
  ASSERT_EQ(sums.whitened.size(), 2U);
  EXPECT_EQ(sums.whitened.at(4).count, 1);
  EXPECT_EQ(sums.whitened.at(4).mean, Vector::Ones(3));

  LawSums fewer, larger;
  fewer.add_whitened(4, Vector::Ones(2));
  larger.add_whitened(4, 2.0 * Vector::Ones(3));
  larger.merge(fewer);
  EXPECT_EQ(larger.whitened.at(4).count, 1);
  larger.merge(sums);
  EXPECT_EQ(larger.whitened.at(4).count, 2);
  EXPECT_EQ(larger.whitened.at(4).mean, 1.5 * Vector::Ones(3));
  EXPECT_EQ(larger.whitened.at(8).count, 1);
}

TEST(LawSums, AddUpTheTailsAndTheNisOfRuns) {
  LawSums sums;
  RunLaw().add_to(sums, "");
  EXPECT_EQ(sums.nees_tails.weights.count + sums.nis_tails.weights.count + sums.nis_of_runs.count, 0);
  EXPECT_EQ(sums.second_moments.runs(), 0);

  RunLaw run;
  run.nees_tails.add(6.0, 2.0);
  run.nis_tails.add(3.0, 1.0);
  run.nis = 9.0;
  run.nis_dof = 6.0;
  run.add_to(sums, "");
  EXPECT_NEAR(sums.nees_tails.weights.mean, 36.0 / 8.0 - 2.0 * 3.0 + 2.0, 1e-14);
  EXPECT_NEAR(sums.nis_tails.weights.mean, 9.0 / 3.0 - 2.0 * 3.0 + 2.0, 1e-14);
  EXPECT_EQ(sums.nis_of_runs.mean, 1.5);

  LawSums later = sums;
  later.nis_at.resize(3);
  later.nis_at[2].add(7.0);
  sums.merge(later);
  EXPECT_EQ(sums.nees_tails.heavier, (CoverageCount{.inside = 0, .total = 2}));  // 36/8 of 9
  EXPECT_EQ(sums.nis_tails.weights.count, 2);
  EXPECT_EQ(sums.nis_of_runs.count, 2);
  ASSERT_EQ(sums.nis_at.size(), 3U);
  EXPECT_EQ(sums.nis_at[2].mean, 7.0);
}

TEST(ShapeSteps, ArePowersOfTwo) {
  std::vector<std::int64_t> steps;
  for (std::int64_t k = 0; k <= 100; ++k) {
    if (is_shape_step(k)) steps.push_back(k);
  }
  EXPECT_EQ(steps, (std::vector<std::int64_t>{1, 2, 4, 8, 16, 32, 64}));
}

}  // namespace
}  // namespace credence::internal
