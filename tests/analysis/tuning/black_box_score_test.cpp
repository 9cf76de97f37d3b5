#include "analysis/tuning/black_box_score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace credence::internal {
namespace {

TEST(ScoreSum, IsTheLogDensityOfItsInnovations) {
  Matrix S(2, 2);
  S << 4.0, 1.0, 1.0, 2.0;  // det 7, inverse [2 −1; −1 4]/7
  ScoreSum sum;
  sum.add(Vector{{1.0, 3.0}}, S);
  sum.add(Vector{{0.0, -1.0}}, S);
  const double first = (2.0 - 6.0 + 36.0) / 7.0, second = 4.0 / 7.0;
  EXPECT_TRUE(sum.ok());
  EXPECT_NEAR(sum.nis(), first + second, 1e-14);
  EXPECT_NEAR(sum.value(), -2.0 * std::log(2.0 * std::numbers::pi) - std::log(7.0) - 0.5 * sum.nis(), 1e-13);
  EXPECT_EQ(sum.steps(), 2.0);
  EXPECT_EQ(sum.dof(), 4.0);
  // ν_1ᵀ S⁻¹ ν_2, whatever root of S is taken.
  EXPECT_NEAR(sum.lag_one(), (1.0 - 12.0) / 7.0, 1e-14);
}

TEST(ScoreSum, CorrelatesOnlyNeighboursOfOneDimension) {
  ScoreSum sum;
  sum.add_normalised(Vector{{1.0, 2.0}}, 0.0);
  sum.add_normalised(Vector::Constant(1, 5.0), 0.0);
  EXPECT_EQ(sum.lag_one(), 0.0);
  sum.add_normalised(Vector::Constant(1, 3.0), 0.0);
  EXPECT_EQ(sum.lag_one(), 15.0);
  EXPECT_EQ(sum.dof(), 4.0);
}

// As python/credence/_tune_filter.py has them: a sensor of a slower rate is compared with itself.
TEST(ScoreSum, CorrelatesSuccessiveInnovationsOfOneSensor) {
  const auto scalar = [](double value) { return Vector(Vector::Constant(1, value)); };
  ScoreSum sum;
  sum.add_normalised(scalar(2.0), 0.0, 0);
  sum.add_normalised(scalar(3.0), 0.0, 1);
  sum.add_normalised(scalar(4.0), 0.0, 0);
  sum.add_normalised(scalar(5.0), 0.0, 0);
  EXPECT_EQ(sum.lag_one(), 2.0 * 4.0 + 4.0 * 5.0);
  sum.add_normalised(scalar(7.0), 0.0, 1);
  EXPECT_EQ(sum.lag_one(), 28.0 + 3.0 * 7.0);
}

TEST(ScoreSum, IsVoidOnceOneInnovationHasNoDensity) {
  const Matrix good = Matrix::Identity(2, 2);
  Matrix indefinite = good;
  indefinite(1, 1) = -1.0;
  Matrix unknown = good;
  unknown(0, 0) = std::nan("");
  Matrix endless = HUGE_VAL * good;
  for (const Matrix& S : {indefinite, unknown, endless, Matrix(Matrix::Zero(2, 2))}) {
    ScoreSum sum;
    sum.add(Vector::Ones(2), S);
    EXPECT_FALSE(sum.ok());
    sum.add(Vector::Ones(2), good);
    EXPECT_FALSE(sum.ok());
  }
  ScoreSum sum;
  sum.add(Vector{{0.0, HUGE_VAL}}, good);
  EXPECT_FALSE(sum.ok());
  ScoreSum spoilt;
  spoilt.add(Vector::Ones(2), good);
  spoilt.spoil();
  EXPECT_FALSE(unit_scores({spoilt}).ok);
}

TEST(UnitScores, AreThoseOfTheUnits) {
  std::vector<ScoreSum> units(3);
  units[0].add_normalised(Vector{{1.0, 2.0}}, 0.3);
  units[2].add_normalised(Vector::Constant(1, 2.0), 0.0);
  units[2].add_normalised(Vector::Constant(1, -1.0), 0.0);
  const UnitScores scores = unit_scores(units);
  EXPECT_TRUE(scores.ok);
  EXPECT_EQ(scores.nis, (Vector{{5.0, 0.0, 5.0}}));
  EXPECT_EQ(scores.lag_one, (Vector{{0.0, 0.0, -2.0}}));
  EXPECT_EQ(scores.value[1], 0.0);
  EXPECT_EQ(scores.steps, 3.0);
  EXPECT_EQ(scores.dof, 4.0);
  EXPECT_FALSE(unit_scores({}).ok);
  EXPECT_FALSE(unit_scores(std::vector<ScoreSum>(4)).ok) << "nothing was measured";
}

/// Twelve units whose values are cubic in φ: a_j φ_0 + b_j φ_1 + φ_0³.
class CubicPlay : public BlackBoxScore {
 public:
  explicit CubicPlay(Index units = 12, double resolution = 0.02)
      : BlackBoxScore({{"first", 2.0}, {"second", 0.5}}, resolution), units_(units) {}
  Index units() const override { return units_; }
  static double a(Index j) { return 1.0 + static_cast<double>(j % 5); }
  static double b(Index j) { return static_cast<double>(j * j % 7) - 3.0; }

 protected:
  UnitScores play(const std::vector<double>& factors) const override {
    const double first = std::log(factors[0] / 2.0), second = std::log(factors[1] / 0.5);
    UnitScores scores;
    scores.value.resize(units_);
    for (Index j = 0; j < units_; ++j) scores.value[j] = a(j) * first + b(j) * second + std::pow(first, 3);
    scores.steps = 1.0;
    scores.ok = first < 1.0;
    return scores;
  }

 private:
  Index units_;
};

TEST(PlayCount, TellsOfThePartsOfAPlayAndOfWholeOnes) {
  PlayCount count;
  std::vector<double> told;
  count.watch([&](double plays) { told.push_back(plays); });
  for (int play = 0; play < 2; ++play) {
    count.add_part_of(4);
    count.add_part_of(4);
    count.finish();
  }
  EXPECT_EQ(told, (std::vector<double>{0.25, 0.5, 1.0, 1.25, 1.5, 2.0}));
}

TEST(BlackBoxScore, TakesItsGradientByCentralDifferences) {
  CubicPlay score;
  double plays = 0.0;
  score.watch([&](double count) { plays = count; });
  const UnitScores scores = score.scores(Vector{{0.5, -0.2}}, true);
  ASSERT_TRUE(scores.ok);
  EXPECT_EQ(plays, 5.0);
  for (Index j = 0; j < 12; ++j) {
    // The differences of a cubic are off by h².
    EXPECT_NEAR(scores.gradient(0, j), CubicPlay::a(j) + 0.75 + 0.02 * 0.02, 1e-10);
    EXPECT_NEAR(scores.gradient(1, j), CubicPlay::b(j), 1e-10);
  }
  EXPECT_EQ(score.scores(Vector{{0.5, -0.2}}, false).gradient.size(), 0);
  EXPECT_EQ(plays, 6);
  EXPECT_FALSE(score.scores(Vector{{2.0, 0.0}}, true).ok);
  EXPECT_FALSE(score.scores(Vector{{0.99, 0.0}}, true).ok) << "a neighbour has no score";
}

TEST(BlackBoxScore, EstimatesTheInformationByTheSpreadOfTheUnits) {
  const Matrix information = CubicPlay().expected_information(Vector::Zero(2));
  double mean_a = 0.0, mean_b = 0.0;
  for (Index j = 0; j < 12; ++j) {
    mean_a += CubicPlay::a(j) / 12.0;
    mean_b += CubicPlay::b(j) / 12.0;
  }
  Matrix expected = Matrix::Zero(2, 2);
  for (Index j = 0; j < 12; ++j) {
    const Vector deviation{{CubicPlay::a(j) - mean_a, CubicPlay::b(j) - mean_b}};
    expected += 12.0 / 11.0 * deviation * deviation.transpose();
  }
  EXPECT_LT((information - expected).norm(), 1e-9);
  EXPECT_EQ(CubicPlay(9).expected_information(Vector::Zero(2)).size(), 0) << "of too few units";
  EXPECT_EQ(CubicPlay().expected_information(Vector{{3.0, 0.0}}).size(), 0) << "where there are no scores";
}

TEST(BlackBoxScore, NamesItsFactors) {
  const CubicPlay score(12, 0.1);
  EXPECT_EQ(score.names(), (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(score.resolution(), 0.1);
  const std::vector<NoiseValue> values = score.values(Vector{{0.0, std::log(4.0)}});
  EXPECT_EQ(values[0].value, 2.0);
  EXPECT_NEAR(values[1].value, 2.0, 1e-15);
  EXPECT_EQ(values[1].gradient, (Vector{{0.0, values[1].value}}));
}

class NoPlay : public BlackBoxScore {
 public:
  using BlackBoxScore::BlackBoxScore;
  explicit NoPlay(std::vector<FilterFactor> factors) : BlackBoxScore(std::move(factors)) {}
  Index units() const override { return 0; }

 protected:
  UnitScores play(const std::vector<double>& /*factors*/) const override { return {}; }
};

TEST(BlackBoxScore, RefusesWhatHasNoFactor) {
  EXPECT_THROW(NoPlay({}), std::invalid_argument);
  for (const double bad : {0.0, -1.0, HUGE_VAL, std::nan("")}) {
    EXPECT_THROW(NoPlay({{"good", 1.0}, {"bad", bad}}), std::invalid_argument) << bad;
  }
}

}  // namespace
}  // namespace credence::internal
