#include "analysis/evidence/sums/law_sums.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

/// A run whose whitened errors and errors are these, of variances 4.
RunLaw run_of(const std::vector<Vector>& whitened) {
  RunLaw run;
  for (const Vector& u : whitened) run.add_error(u, 2.0 * u, Vector::Constant(u.size(), 4.0));
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
  for (int k = 0; k < 640; ++k) {
    const double sign = k % 2 == 0 ? 1.0 : -1.0;
    slow.push_back(Vector{{sign, k < 320 ? 1.0 : -1.0}});
    fast.push_back(Vector{{sign, k % 4 < 2 ? 1.0 : -1.0}});
  }
  const LawSums sums = sums_of(slow);
  ASSERT_EQ(sums.stretches.means.count, 10);
  EXPECT_NEAR(sums.whitened_means.mean.norm(), 0.0, 1e-12);
  EXPECT_NEAR(sums.stretches.means.scatter(1, 1), 10.0, 1e-9);
  EXPECT_NEAR(sums.stretches.means.scatter(0, 0), 0.0, 1e-9);
  EXPECT_FALSE(sums.errors_stand());
  EXPECT_FALSE(sums.stretches.stay());
  EXPECT_TRUE(sums.stretches.stand(640.0));
  EXPECT_FALSE(sums.stretches.stand(2.0)) << "chance may do it";
  EXPECT_FALSE(sums_of(fast).stretches.stand(640.0));
  const LawSums constant = sums_of(std::vector<Vector>(640, Vector{{1.0, 2.0}}));
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
    run.large.add(u, true);
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

// Rows taken for the mean square of a long run stand for those after them.
TEST(StretchSums, OfALongRunTakeRowsEvenly) {
  RunWhitened all, thinned;
  for (Index k = 0; k < 10'000; ++k) {
    const Vector u{{k < 5000 ? 1.0 : 3.0, 1.0}};
    all.add(u);
    thinned.add(u, true);
  }
  EXPECT_EQ(all.outer(0, 0), 50'000.0);
  EXPECT_NEAR(thinned.outer(0, 0), 50'000.0, 200.0);
  EXPECT_NEAR(thinned.outer(1, 0), 20'000.0, 100.0);
  EXPECT_EQ(all.mean(), thinned.mean());
  EXPECT_EQ(all.mean(), (Vector{{2.0, 1.0}}));
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
  run.add_error(Vector{{1.0, 1.0}}, Vector{{3.0, -8.0}}, Vector{{9.0, 16.0}});
  LawSums sums;
  run.add_to(sums, "");
  EXPECT_EQ(sums.error_means.mean, (Vector{{1.0, -2.0}}));
}

TEST(LawSums, KeepTheStatesThatARunBeganWith) {
  RunLaw run = run_of({Vector{{1.0, 2.0}}});
  run.add_error(Vector::Ones(3), Vector::Ones(3), Vector::Ones(3));
  EXPECT_EQ(run.averaged.steps, 1);
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
  EXPECT_EQ(sums.nees_tails.count + sums.nis_tails.count + sums.nis_of_runs.count, 0);
  EXPECT_EQ(sums.second_moments.runs(), 0);

  RunLaw run;
  run.nees_tails.add(6.0, 2.0);
  run.nis_tails.add(3.0, 1.0);
  run.nis = 9.0;
  run.nis_dof = 6.0;
  run.add_to(sums, "");
  EXPECT_NEAR(sums.nees_tails.mean, 36.0 / 8.0 - 2.0 * 3.0 + 2.0, 1e-14);
  EXPECT_NEAR(sums.nis_tails.mean, 9.0 / 3.0 - 2.0 * 3.0 + 2.0, 1e-14);
  EXPECT_EQ(sums.nis_of_runs.mean, 1.5);

  LawSums later = sums;
  later.nees_at.resize(3);
  later.nees_at[2].add(5.0);
  later.nis_at.resize(1);
  later.nis_at[0].add(7.0);
  sums.merge(later);
  EXPECT_EQ(sums.nees_tails.count, 2);
  EXPECT_EQ(sums.nis_tails.count, 2);
  EXPECT_EQ(sums.nis_of_runs.count, 2);
  ASSERT_EQ(sums.nees_at.size(), 3U);
  EXPECT_EQ(sums.nees_at[2].mean, 5.0);
  EXPECT_EQ(sums.nis_at[0].mean, 7.0);
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
