#include "analysis/calibration/calibration.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "core/nan.h"

namespace credence::internal {
namespace {

RunLayout pose_layout() {
  RunLayout layout{.states = {"vehicle.x", "vehicle.y", "vehicle.heading"}, .angles = {false, false, true}};
  add_named_blocks(layout);
  return layout;
}

/// Runs of errors with covariance F P F, correlated by `correlation` from row to row; P changes in size by
/// 10 within a run.
struct Played {
  std::vector<CalibrationRun> runs;
  std::vector<Block> parts;
};

Played play_rows(std::uint64_t seed, int runs, int rows, const Eigen::Vector3d& F, double correlation = 0.0,
                 double tail = 1.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  CalibrationRecorder recorder;
  Eigen::Matrix3d C;
  C << 1.0, 0.3, 0.2, 0.3, 1.0, -0.4, 0.2, -0.4, 1.0;
  for (int run = 0; run < runs; ++run) {
    recorder.begin_run(pose_layout(), "run-" + std::to_string(run));
    const double size = uniform(random) < 0.5 ? 1.0 : tail;  // of a run as a whole
    Eigen::Vector3d white = Eigen::Vector3d::NullaryExpr([&] { return normal(random); });
    for (int k = 0; k < rows; ++k) {
      const Eigen::Vector3d fresh = Eigen::Vector3d::NullaryExpr([&] { return normal(random); });
      white = correlation * white + std::sqrt(1.0 - correlation * correlation) * fresh;
      const Eigen::Vector3d sigma = (k % 2 == 0 ? 1.0 : 10.0) * Eigen::Vector3d(0.2, 0.1, 0.02);
      const Eigen::Matrix3d P = sigma.asDiagonal() * C * sigma.asDiagonal();
      Step step;
      step.step = k + 1;
      step.states = {0, 1, 2};
      step.error = size * F.cwiseProduct(Eigen::Vector3d(P.llt().matrixL() * white));
      step.P = P;
      recorder.add(step);
    }
  }
  Played played{recorder.take(), recorder.parts()};
  return played;
}

Calibration judged(const Played& played, double confidence = 0.95) {
  return judge_calibration(played.runs, played.parts, {}, confidence);
}

const Eigen::Vector3d kRight = Eigen::Vector3d::Ones();

// P is the same in all rows of a range of σ here, so that the factor is the ratio of mean squares.
TEST(Calibration, OfARunThatIsTooShortForStretchesFactorsHaveNoInterval) {
  const Calibration c = judged(play_rows(3, 1, 60, kRight, 0.99));
  ASSERT_EQ(c.unit_count, 0);
  ASSERT_EQ(c.bins.size(), 6U);
  for (const SigmaBin& bin : c.bins) {
    EXPECT_NEAR(bin.factor.mean, bin.rmse * bin.rmse / (bin.claimed * bin.claimed), 1e-9);
    EXPECT_TRUE(std::isnan(bin.factor.lower) && std::isnan(bin.p_value));
  }
}

TEST(CalibrationParts, ArePositionAndHeadingOfAPose) {
  const std::vector<Block> parts = calibration_parts(pose_layout());
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].states, (std::vector<Index>{0, 1}));
  EXPECT_EQ(parts[1].states, std::vector<Index>{2});
  RunLayout map{.states = {"vehicle", "landmark1", "landmark2"}, .angles = {false, false, false}};
  map.blocks = {{"vehicle", Part::position, {0}},
                {"landmark1", Part::landmark, {1}},
                {"landmark2", Part::landmark, {2}},
                {"all landmarks", Part::map, {1, 2}}};
  ASSERT_EQ(calibration_parts(map).size(), 2U);
  EXPECT_EQ(calibration_parts(map)[1].states, (std::vector<Index>{1, 2}));
  EXPECT_EQ(calibration_parts({.states = {"a", "b"}, .angles = {false, false}}).at(0).states.size(), 2U);
}

TEST(Calibration, PairsGiveNeesOfAScaledCovariance) {
  // One row by hand: P' = D P D with D = diag(√f).
  CalibrationRecorder recorder;
  recorder.begin_run(pose_layout(), "one");
  Step step;
  step.step = 1;
  step.states = {0, 1, 2};
  step.error = Eigen::Vector3d(0.3, -0.2, 0.5);
  step.P.resize(3, 3);
  step.P << 1.0, 0.2, 0.3, 0.2, 2.0, -0.1, 0.3, -0.1, 0.5;
  recorder.add(step);
  const CalibrationSum sum = recorder.take().at(0).whole;
  const double position = 4.0, heading = 0.25;
  const Eigen::Vector3d D(2.0, 2.0, 0.5);
  const Matrix scaled = D.asDiagonal() * step.P * D.asDiagonal();
  EXPECT_NEAR(sum.pairs[0] / position + sum.pairs[1] / std::sqrt(position * heading) + sum.pairs[2] / heading,
              step.error.dot(scaled.inverse() * step.error), 1e-12);
  EXPECT_NEAR(sum.marginal[1], 0.5, 1e-12);
  EXPECT_NEAR(3.0 * sum.nees, step.error.dot(step.P.inverse() * step.error), 1e-12);
}

TEST(Calibration, FactorsOfPartsAreFoundAndHoldOnWhatWasLeftOut) {
  constexpr double kFiveSigma = 1.0 - 5.7e-7;
  const Calibration c = judged(play_rows(1, 60, 50, Eigen::Vector3d(1.0, 1.0, 3.0)), kFiveSigma);
  EXPECT_EQ(c.units, "runs");
  ASSERT_EQ(c.parts.size(), 2U);
  EXPECT_LT(c.parts[0].factor.lower, 1.0);
  EXPECT_GT(c.parts[0].factor.upper, 1.0);
  EXPECT_LT(c.parts[1].factor.lower, 9.0);
  EXPECT_GT(c.parts[1].factor.upper, 9.0);
  EXPECT_NEAR(c.with_part_factors.mean, 1.0, 0.1);
  // Where the claimed σ of the heading is small it is too small as where it is large.
  for (const SigmaBin& bin : c.bins) {
    EXPECT_EQ(bin.adjusted < 0.05, bin.state == 2) << bin.state << ' ' << bin.lower;
    EXPECT_NEAR(bin.rmse / bin.claimed, bin.state == 2 ? 3.0 : 1.0, 0.25);
  }
  EXPECT_EQ(c.bins.size(), 6U);
}

/// 40 runs of 20 rows of one state whose σ is drawn anew for each row, 0.5 or 2: what the errors have of it.
Calibration by_sigma(std::uint64_t seed, double of_small, double of_large, bool varies = true) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> coin(0, 1);
  CalibrationRecorder recorder;
  for (int run = 0; run < 40; ++run) {
    recorder.begin_run({.states = {"x"}, .angles = {false}, .units = {"m/s"}}, "run");
    for (int k = 0; k < 20; ++k) {
      const bool small = coin(random) == 0;
      const double sigma = small || !varies ? 0.5 : 2.0;
      Step step;
      step.step = k + 1;
      step.states = {0};
      step.error = Vector::Constant(1, (small ? of_small : of_large) * sigma * normal(random));
      step.P = Matrix::Constant(1, 1, sigma * sigma);
      recorder.add(step);
    }
  }
  const std::vector<CalibrationRun> runs = recorder.take();
  return judge_calibration(runs, recorder.parts(), recorder.layout(), 0.95);
}

// ½ · 1.6 + ½ · 0.4 = 1, and yet every row is wrong.
TEST(Calibration, ClaimedSigmaTellsWhatIsRightOnAverage) {
  const Calibration c = by_sigma(5, std::sqrt(1.6), std::sqrt(0.4));
  EXPECT_LT(c.whole.factor.lower, 1.0);
  EXPECT_GT(c.whole.factor.upper, 1.0);
  EXPECT_LT(c.claimed_sigma.optimistic.p_value, 1e-4);
  EXPECT_EQ(c.claimed_sigma.optimistic.in, "x where its σ is 0.316 to 0.562 m/s");
  EXPECT_NEAR(c.claimed_sigma.optimistic.factor.mean, 1.6, 0.57);  // 5 √(2/400) of it
  EXPECT_LT(c.claimed_sigma.pessimistic.p_value, 1e-6);
  EXPECT_EQ(c.claimed_sigma.pessimistic.in, "x where its σ is 1.78 to 3.16 m/s");
  EXPECT_EQ(c.claimed_sigma.units, 40);
}

// Of the ranges of a right filter one rejects as often as said, and one range alone is that of NEES.
TEST(Calibration, ClaimedSigmaHoldsItsLevel) {
  int rejected = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const ClaimedSigmaTest test = by_sigma(seed, 1.0, 1.0).claimed_sigma;
    rejected += std::min(test.optimistic.p_value, test.pessimistic.p_value) <= 0.05 ? 1 : 0;
  }
  EXPECT_LE(rejected, 41);  // 20 and 5 standard errors of a binomial(400, 0.05)
  EXPECT_GT(rejected, 0);
  EXPECT_TRUE(std::isnan(by_sigma(1, 3.0, 3.0, false).claimed_sigma.optimistic.p_value));
}

// σ² of a row is 0.1 and 0.9 of the square of the error before it: exact, and yet the rows of a run that come
// to a range follow its errors. Averages over them are not 1 in the mean: 20 of 20 such filters were refused.
TEST(Calibration, ClaimedSigmaMayFollowTheErrors) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  int rejected = 0;
  for (int study = 0; study < 20; ++study) {
    CalibrationRecorder recorder;
    for (int run = 0; run < 400; ++run) {
      recorder.begin_run({.states = {"x"}, .angles = {false}}, "run");
      Step step;
      step.states = {0};
      step.P = Matrix::Constant(1, 1, 0.5);
      for (int k = 0; k < 20; ++k) {
        step.step = k + 1;
        step.error = Vector::Constant(1, std::sqrt(step.P(0, 0)) * normal(random));
        recorder.add(step);
        step.P(0, 0) = 0.1 + 0.9 * step.error[0] * step.error[0];
      }
    }
    const ClaimedSigmaTest test = judge_calibration(recorder, 0.95).claimed_sigma;
    rejected += std::min(test.optimistic.p_value, test.pessimistic.p_value) <= 0.05 ? 1 : 0;
  }
  EXPECT_LE(rejected, 5);  // 1, and five standard errors of a binomial(20, 0.05)
}

// One run of a correlated error: its stretches are units, and 100 right runs are refused as often as said.
TEST(Calibration, OneRunIsJudgedByItsStretches) {
  int refused = 0, judged_runs = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Calibration c = judged(play_rows(seed, 1, 2000, kRight, 0.7));
    if (c.units.empty()) continue;
    ++judged_runs;
    EXPECT_EQ(c.units, "stretches");
    EXPECT_EQ(c.unit_count, 20);
    for (const SigmaBin& bin : c.bins) {
      if (bin.adjusted <= 0.05) {
        ++refused;
        break;
      }
    }
  }
  EXPECT_GT(judged_runs, 50);
  EXPECT_LE(refused, 16);  // 5 and 5 standard errors of a binomial(100, 0.05)
  const Calibration wrong = judged(play_rows(7, 1, 2000, 2.0 * kRight, 0.7));
  EXPECT_GT(wrong.whole.factor.lower, 1.5);
  EXPECT_TRUE(judged(play_rows(8, 1, 60, kRight, 0.95)).units.empty());
}

// Two logs are paired by their tenths, however many stretches each of them has.
TEST(Calibration, StretchesOfTwoLogsAreOfTheSameRows) {
  const Played one = play_rows(7, 1, 2000, kRight, 0.7);
  ASSERT_EQ(one.runs.front().stretches.size(), 20U);
  const UnitFactors tenths = unit_factors(one.runs, one.parts);
  ASSERT_EQ(tenths.names.size(), 10U);
  const CalibrationSum &first = one.runs.front().stretches[18], &second = one.runs.front().stretches[19];
  EXPECT_NEAR(tenths.factors[0][9],
              (first.nees + second.nees) / static_cast<double>(first.rows + second.rows), 1e-12);
  const Played two = play_rows(7, 2, 2000, kRight, 0.7);
  EXPECT_EQ(judged(two).unit_count, 20);
}

// Of 2,000 rows twenty stretches are 99 rows each, or a little more.
TEST(Calibration, StretchesAreAsLongAsTheErrorsRemember) {
  const Played one = play_rows(7, 1, 2000, kRight, 0.7);
  CalibrationUnits units{.runs = one.runs, .parts = one.parts};
  const auto count = [&](double memory) {
    units.memory = memory;
    return judge_calibration(units, 0.95).unit_count;
  };
  EXPECT_EQ(count(kNaN), 20);
  EXPECT_EQ(count(13.0), 20);
  EXPECT_EQ(count(20.0), 10);
  EXPECT_EQ(count(30.0), 0);
}

// Over 100 sets of 40 runs with heavy tails: a further run is covered in at least 95 % of the cases.
TEST(Calibration, TheConformalFactorCoversFurtherRuns) {
  int covered = 0;
  constexpr int kSets = 100;
  for (std::uint64_t seed = 1; seed <= kSets; ++seed) {
    const Played played = play_rows(seed, 41, 20, kRight, 0.5, 3.0);
    const Calibration c = judge_calibration(std::span(played.runs).first(40), played.parts, {}, 0.95);
    covered += played.runs.back().coverage_factor <= c.conformal.factor ? 1 : 0;
  }
  EXPECT_GE(covered, 84);  // 95 less 5 standard errors of a binomial(100, 0.95)
  EXPECT_TRUE(std::isnan(judged(play_rows(1, 18, 20, kRight)).conformal.factor));
  EXPECT_FALSE(std::isnan(judged(play_rows(1, 19, 20, kRight)).conformal.factor));
}

TEST(Calibration, ProtectionLevelsCountWhatLiesBeyond) {
  const Calibration c = judged(play_rows(3, 20, 100, 4.0 * kRight));
  const ProtectionLevel& level = c.protection[0];
  EXPECT_NEAR(level.k, 3.0349, 1e-3);  // χ²(2): 9.2103 at 1 %
  EXPECT_EQ(level.rows, 2000);
  EXPECT_GT(level.beyond, 200);
  EXPECT_GT(level.upper_limit, 0.1);
  EXPECT_NEAR(c.protection[2].needed_rows, 299'571.7, 1.0);  // ln 0.05 / ln(1 − 1e-5)
  const Calibration right = judged(play_rows(4, 20, 100, kRight));
  EXPECT_LT(right.protection[2].upper_limit, 0.01);
  EXPECT_GT(right.protection[2].upper_limit, 1e-3);  // some 2,000 rows show no more
  EXPECT_GT(right.protection[0].effective_rows, 1000.0);
}

/// 20 runs of 64 rows, 0.5 m from one to the next; behind 16 m the errors are `factor` times what P says.
Calibration on_the_way(double factor) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  CalibrationRecorder recorder;
  for (int run = 0; run < 20; ++run) {
    recorder.begin_run(pose_layout(), "run");
    for (int k = 0; k < 64; ++k) {
      const double size = k < 32 ? 1.0 : factor;
      Step step;
      step.step = k + 1;
      step.states = {0, 1, 2};
      step.error = size * Eigen::Vector3d::NullaryExpr([&] { return normal(random); });
      step.P = Eigen::Matrix3d::Identity();
      recorder.add(step, 0.5 * k);
    }
  }
  return judge_calibration(recorder.take(), recorder.parts(), {}, 0.95);
}

TEST(Calibration, NeesOverTheWayTellsFromWhereOnPIsWrong) {
  const Calibration c = on_the_way(2.0);
  ASSERT_EQ(c.distance.size(), 16U);  // of 2 m each
  for (std::size_t i = 0; i < c.distance.size(); ++i) {
    const DistanceBin& bin = c.distance[i];
    EXPECT_EQ(bin.from_m, 2.0 * static_cast<double>(i));
    EXPECT_EQ(bin.rows, 80);
    const double expected = i < 8 ? 1.0 : 4.0;
    // χ²(3)/3 of 80 rows; five standard errors.
    EXPECT_NEAR(bin.nees.mean, expected, 5.0 * expected * std::sqrt(2.0 / 3.0 / 80.0)) << i;
    EXPECT_EQ(bin.adjusted < 0.01, i >= 8) << i << ": " << bin.adjusted;
    EXPECT_NEAR(bin.error_m / bin.sigma_m, std::sqrt(expected), 5.0 * std::sqrt(expected / 4.0 / 80.0));
  }
  for (const DistanceBin& bin : on_the_way(1.0).distance) EXPECT_GT(bin.adjusted, 0.01);
}

TEST(Calibration, RunsOfDifferentLengthsShareTheLengthsOfTheWay) {
  DistanceSums near, far;
  for (int k = 0; k < 10; ++k) near.add(0.25 * k, {.rows = 1, .nees = 1.0, .squared = 4.0, .variance = 1.0});
  for (int k = 0; k < 100; ++k) far.add(k, {.rows = 1, .nees = 2.0});
  far.add(std::nan(""), {.rows = 1});
  far.add(-1.0, {.rows = 1});
  EXPECT_EQ(near.length_m(), 0.25);
  EXPECT_EQ(far.length_m(), 8.0);
  near.widen(far.length_m());
  ASSERT_EQ(near.bins().size(), 1U);
  EXPECT_EQ(near.bins()[0].rows, 10);
  EXPECT_EQ(near.bins()[0].squared, 40.0);
  EXPECT_EQ(far.bins().size(), 13U);
  EXPECT_EQ(far.bins()[12].rows, 4);
}

TEST(Calibration, TheStanfordDiagramHoldsEveryRowAtItsErrorAndItsClaim) {
  const Calibration c = on_the_way(1.0);
  std::int64_t rows = 0;
  for (const StanfordCell& cell : c.stanford) {
    rows += cell.rows;
    EXPECT_NEAR(std::log10(cell.sigma), 0.0625, 1e-12);  // √λ_max = 1: the cell from 1 on
    EXPECT_LT(cell.error, 10.0);
  }
  EXPECT_EQ(rows, 20 * 64);
  EXPECT_EQ(c.protection[1].rows, rows);
}

TEST(Calibration, AChangeIsFoundInThePartWhereItIs) {
  const Played before = play_rows(5, 30, 40, kRight), same = play_rows(6, 30, 40, kRight);
  const Played after = play_rows(6, 30, 40, Eigen::Vector3d(1.0, 1.0, 1.5));
  const UnitFactors first = unit_factors(before.runs, before.parts);
  for (const FactorChange& change : compare_factors(unit_factors(same.runs, same.parts), first, 0.95))
    EXPECT_GT(change.adjusted, 1e-3) << change.part;
  const std::vector<FactorChange> changes =
      compare_factors(unit_factors(after.runs, after.parts), first, 0.95);
  ASSERT_EQ(changes.size(), 3U);
  EXPECT_EQ(changes[1].part, "position");
  EXPECT_GT(changes[1].adjusted, 1e-3);
  EXPECT_LT(changes[2].adjusted, 1e-6);
  EXPECT_LT(changes[2].ratio.lower, 2.25);
  EXPECT_GT(changes[2].ratio.upper, 2.25);
  UnitFactors other = first;
  for (std::string& name : other.names) name += " of another log";
  EXPECT_TRUE(compare_factors(other, first, 0.95).empty());
}

// P of one log is a multiple of the other's: the factors of the units differ by rounding alone.
TEST(Calibration, AMultipleOfAllFactorsIsKnownExactly) {
  UnitFactors first{.units = "runs", .names = {}, .parts = {"NEES"}, .factors = {{}}}, second;
  for (int unit = 0; unit < 12; ++unit) {
    first.names.push_back(std::to_string(unit));
    first.factors[0].push_back(1.0 + 0.1 * std::sin(1.0 + 3.0 * unit));
  }
  for (const double multiple : {1.0 / 3.0, 1.01, 1.7}) {
    second = first;
    for (double& factor : second.factors[0]) factor *= multiple;
    const std::vector<FactorChange> changes = compare_factors(second, first, 0.95);
    ASSERT_EQ(changes.size(), 1U);
    // The ends are searched to 30 bits.
    EXPECT_NEAR(changes[0].ratio.lower, multiple, 0x1p-28 * multiple);
    EXPECT_NEAR(changes[0].ratio.upper, multiple, 0x1p-28 * multiple);
    EXPECT_LT(changes[0].p_value, 1e-4);
  }
}

}  // namespace
}  // namespace credence::internal
