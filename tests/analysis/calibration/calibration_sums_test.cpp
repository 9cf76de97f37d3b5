#include "analysis/calibration/calibration_sums.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <utility>

#include "analysis/evidence/sums/evidence_recorder.h"

namespace credence::internal {
namespace {

RunLayout layout_of_numbers(std::size_t states) {
  return {.states = std::vector<std::string>(states, "s"), .angles = std::vector<bool>(states, false)};
}

// A position and a heading, which are two parts.
RunLayout layout_of_parts() {
  RunLayout layout = layout_of_numbers(3);
  layout.blocks = {{"position", Part::position, {0, 1}}, {"heading", Part::heading, {2}}};
  return layout;
}

Step step_of_errors(const Vector& error, const Matrix& P) {
  Step step{.step = 1, .error = error, .P = P};
  for (Index i = 0; i < error.size(); ++i) step.states.push_back(i);
  return step;
}

Step step_of_number(double squared, double variance) {
  return step_of_errors(Vector::Constant(1, std::sqrt(squared)), Matrix::Constant(1, 1, variance));
}

TEST(CalibrationRecorder, PartsAndPairsAreThoseOfTheInverse) {
  const Vector e{{1.0, -2.0, 0.5}};
  const Matrix P{{2.0, 1.0, 0.3}, {1.0, 2.0, -0.2}, {0.3, -0.2, 0.25}};
  CalibrationRecorder recorder;
  recorder.begin_run(layout_of_parts(), "one");
  recorder.add(step_of_errors(e, P), 3.0);
  const std::vector<CalibrationRun> runs = recorder.take();
  ASSERT_EQ(runs.size(), 1U);
  const CalibrationSum& sum = runs[0].whole;
  const Matrix I = P.inverse();
  EXPECT_NEAR(sum.nees, e.dot(I * e) / 3.0, 1e-13);
  ASSERT_EQ(sum.marginal.size(), 2U);
  EXPECT_NEAR(sum.marginal[0], (2.0 + 4.0 + 8.0) / 3.0 / 2.0, 1e-13);  // of [2 1; 1 2] by hand
  EXPECT_NEAR(sum.marginal[1], 1.0, 1e-13);
  ASSERT_EQ(sum.pairs.size(), 3U);
  EXPECT_NEAR(sum.pairs[0], e.head(2).dot(I.topLeftCorner(2, 2) * e.head(2)), 1e-13);
  EXPECT_NEAR(sum.pairs[1], 2.0 * e.head(2).dot(I.topRightCorner(2, 1) * e.tail(1)), 1e-13);
  EXPECT_NEAR(sum.pairs[2], e[2] * e[2] * I(2, 2), 1e-13);
  // λ_max of [2 1; 1 2] is 3: cells floor(8 log10 √5) and floor(8 log10 √3).
  ASSERT_EQ(runs[0].stanford.size(), 1U);
  EXPECT_EQ(runs[0].stanford.begin()->first, (std::pair{2, 1}));
  EXPECT_EQ(runs[0].beyond, (std::array<std::int64_t, 3>{0, 0, 0}));
  EXPECT_EQ(runs[0].position_dim, 2);
  ASSERT_EQ(runs[0].distance.bins().size(), 1U + static_cast<std::size_t>(3.0 / runs[0].distance.length_m()));
  EXPECT_EQ(runs[0].distance.bins().back().squared, 5.0);
  EXPECT_EQ(runs[0].distance.bins().back().variance, 4.0);
}

TEST(CalibrationRecorder, TakesTheFactorAtHandToTheSameBits) {
  RunLayout layout = layout_of_parts();
  layout.blocks.insert(layout.blocks.begin(), {"pose", Part::pose, {0, 1, 2}});
  EvidenceRecorder evidence(layout);
  CalibrationRecorder alone, given;
  evidence.begin_run();
  alone.begin_run(layout, "run");
  given.begin_run(layout, "run");
  const Matrix P{{2.0, 1.0, 0.3}, {1.0, 2.0, -0.2}, {0.3, -0.2, 0.25}};
  for (const double scale : {0.7, 1.0, 1.3}) {
    const Step step = step_of_errors(scale * Vector{{1.0, -2.0, 0.5}}, scale * P);
    evidence.add(step);
    ASSERT_NE(evidence.factored().factor, nullptr);
    alone.add(step);
    given.add(step, kNaN, evidence.factored());
  }
  const CalibrationRun a = alone.take().at(0), b = given.take().at(0);
  EXPECT_EQ(a.whole.rows, 3);
  EXPECT_EQ(a.whole.nees, b.whole.nees);
  EXPECT_EQ(a.whole.marginal, b.whole.marginal);
  EXPECT_EQ(a.whole.pairs, b.whole.pairs);

  Step certain = step_of_errors(Vector{{1.0, -2.0, 0.0}}, Matrix(Vector{{2.0, 2.0, 1e-40}}.asDiagonal()));
  certain.step = 4;
  certain.estimate = Vector{{0.0, 0.0, 1.0}};
  evidence.add(certain);  // judged by another P than the step has
  EXPECT_EQ(evidence.factored().factor, nullptr);
}

TEST(CalibrationRecorder, CountsWhatIsBeyondEachLevel) {
  CalibrationRecorder recorder;
  recorder.begin_run(layout_of_parts(), "run");
  const Matrix P = Vector{{1.0, 4.0, 1.0}}.asDiagonal();
  // −2 ln p of two dimensions: 9.21, 13.82 and 23.03, times λ_max = 4.
  for (const double squared : {36.0, 37.0, 56.0, 92.0, 93.0})
    recorder.add(step_of_errors(Vector{{std::sqrt(squared), 0.0, 0.0}}, P));
  EXPECT_EQ(recorder.take().at(0).beyond, (std::array<std::int64_t, 3>{4, 3, 1}));
}

TEST(CalibrationRecorder, BinsRowsByTheSigmaThatTheyClaim) {
  CalibrationRecorder recorder;
  recorder.begin_run(layout_of_numbers(1), "run");
  for (const double variance : {1.0, 1.0, 3.0, 3.2, 1.0, 0.99}) recorder.add(step_of_number(6.0, variance));
  const CalibrationRun run = recorder.take().at(0);
  ASSERT_EQ(run.whole.bins.size(), 3U);  // 10^(bin/2) ≤ σ²: 3.2 lies beyond √10, 0.99 below 1
  const CalibrationSum::Bin& bin = run.whole.bins.at({0, 0});
  EXPECT_EQ(bin.rows, 4);
  EXPECT_NEAR(bin.squared, 24.0, 1e-12);
  EXPECT_EQ(bin.variance, 6.0);
  EXPECT_NEAR(bin.normalised, 3.0 * 6.0 + 2.0, 1e-12);
  EXPECT_EQ(run.whole.bins.at({0, 1}).rows, 1);
  EXPECT_EQ(run.whole.bins.at({0, -1}).rows, 1);
  EXPECT_EQ(recorder.parts().at(0).name, "state");
}

// The oracle is the definition: 400 rows of three states, whose variances cross bins, touch their edges and
// jump, so that bins come up in any order and groups of rows are joined.
TEST(CalibrationRecorder, EveryVarianceIsInTheBinOfItsLogarithm) {
  CalibrationRecorder recorder;
  recorder.begin_run(layout_of_numbers(3), "run");
  std::map<std::pair<Index, int>, CalibrationSum::Bin> expected;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> exponent(-6.0, 6.0);
  Vector variance = Vector::Ones(3);
  for (int k = 0; k < 400; ++k) {
    for (Index i = 0; i < 3; ++i) {
      const double edge = std::pow(10.0, 0.5 * (k % 9 - 4));
      if (k % 7 == i)
        variance[i] = std::pow(10.0, exponent(random));
      else if (k % 5 == i)
        variance[i] = k % 3 == 0 ? edge : std::nextafter(edge, k % 3 == 1 ? 0.0 : 1e9);
      else
        variance[i] *= 1.01;
      CalibrationSum::Bin& bin = expected[{i, static_cast<int>(std::floor(2.0 * std::log10(variance[i])))}];
      ++bin.rows;
      bin.variance += variance[i];
    }
    recorder.add(step_of_errors(Vector::Ones(3), variance.asDiagonal()));
  }
  const CalibrationSum whole = recorder.take().at(0).whole;
  ASSERT_EQ(whole.bins.size(), expected.size());
  for (const auto& [place, bin] : expected) {
    ASSERT_TRUE(whole.bins.contains(place)) << place.first << ", " << place.second;
    EXPECT_EQ(whole.bins.at(place).rows, bin.rows) << place.first << ", " << place.second;
    EXPECT_NEAR(whole.bins.at(place).variance, bin.variance, 1e-12 * bin.variance);
  }
}

TEST(CalibrationRecorder, StretchesAreTheRowsInTheirOrder) {
  // 1,000 rows fill 125 groups of eight; twenty stretches of six groups leave the last rows out.
  CalibrationRecorder recorder;
  recorder.begin_run(layout_of_numbers(1), "run");
  for (int k = 0; k < 1000; ++k) {
    const double variance = k < 48 ? 1.0 : k < 912 ? 100.0 : 10'000.0;
    recorder.add(step_of_number((k % 2 == 0 ? 0.5 : 1.5) * variance, variance));
  }
  const CalibrationRun run = recorder.take().at(0);
  EXPECT_EQ(run.whole.rows, 1000);
  EXPECT_NEAR(run.whole.nees, 1000.0, 1e-9);
  EXPECT_EQ(run.effective_rows, 1000.0);  // no two rows agree by more than chance
  ASSERT_EQ(run.stretches.size(), 2 * CalibrationRun::kTenths);
  for (std::size_t s = 0; s < run.stretches.size(); ++s) {
    const int bin = s == 0 ? 0 : s == 19 ? 8 : 4;
    EXPECT_EQ(run.stretches[s].rows, 48) << s;
    ASSERT_EQ(run.stretches[s].bins.size(), 1U) << s;
    EXPECT_EQ(run.stretches[s].bins.begin()->first, (std::pair<Index, int>{0, bin})) << s;
    EXPECT_NEAR(run.stretches[s].nees, 48.0, 1e-9) << s;
  }
}

// Of errors whose NEES forgets so slowly that a twentieth is too short, or a tenth as well; of 190 rows there
// are 95 groups, of which a tenth has nine.
TEST(CalibrationRecorder, StretchesAreAsManyAsAreIndependent) {
  CalibrationRecorder recorder;
  for (const auto& [rows, repeated] :
       {std::pair{1600, 1}, std::pair{1600, 20}, std::pair{1600, 60}, std::pair{190, 2}}) {
    recorder.begin_run(layout_of_numbers(1), "run");
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    for (int k = 0; k < rows; k += repeated) {
      const double squared = std::pow(normal(random), 2);
      for (int i = 0; i < repeated; ++i) recorder.add(step_of_number(squared, 1.0));
    }
  }
  const std::vector<CalibrationRun> runs = recorder.take();
  const std::size_t expected[] = {20, 10, 0, 10};
  for (std::size_t i = 0; i < runs.size(); ++i) EXPECT_EQ(runs[i].stretches.size(), expected[i]) << i;
}

TEST(CalibrationRecorder, OfManyRunsNoStretchesAreKept) {
  CalibrationRecorder recorder;
  for (int run = 0; run < 6; ++run) {
    recorder.begin_run(layout_of_numbers(1), "run");
    for (int k = 0; k < 200; ++k) recorder.add(step_of_number(k % 2 == 0 ? 0.5 : 1.5, 1.0));
  }
  const std::vector<CalibrationRun> runs = recorder.take();
  for (std::size_t r = 0; r < runs.size(); ++r) EXPECT_EQ(runs[r].stretches.empty(), r >= 4) << r;
}

// Of autoregressions worth 16 and 106 rows; as the rows over their correlation time they came out as 34 and
// 127.
TEST(CalibrationRecorder, TheEffectiveRowsAreThoseOfTheMean) {
  constexpr int kRuns = 400;
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  for (const auto& [memory, rows] : {std::pair{0.95, 300}, std::pair{0.9, 1000}}) {
    CalibrationRecorder recorder;
    for (int run = 0; run < kRuns; ++run) {
      recorder.begin_run(layout_of_numbers(1), "run");
      double x = normal(random);
      for (int k = 0; k < rows; ++k) {
        recorder.add(step_of_number(x * x, 1.0));
        x = memory * x + std::sqrt(1.0 - memory * memory) * normal(random);
      }
    }
    double mean = 0.0;
    for (const CalibrationRun& run : recorder.take()) mean += run.effective_rows / kRuns;
    double correlation_time = 1.0;  // of x², whose correlation is memory^(2h)
    for (int h = 1; h < rows; ++h)
      correlation_time += 2.0 * (1.0 - static_cast<double>(h) / rows) * std::pow(memory, 2 * h);
    EXPECT_NEAR(mean / (rows / correlation_time), 1.0, 0.2) << memory;
  }
}

TEST(CalibrationRecorder, TheCoverageFactorIsTheQuantileOfTheRows) {
  CalibrationRecorder recorder;
  recorder.begin_run(layout_of_numbers(1), "run");
  for (int i = 0; i < 20; ++i) recorder.add(step_of_number(1.0 + (7 * i) % 20, 1.0));  // 1 … 20
  // 19 of 20 are 95 %; χ²₀.₉₅(1) = 3.84146.
  EXPECT_NEAR(recorder.take().at(0).coverage_factor, 19.0 / 3.841458820694124, 1e-9);
}

TEST(CalibrationRecorder, LeavesOutWhatItCannotUse) {
  CalibrationRecorder recorder;
  RunLayout blind = layout_of_numbers(1), apart = layout_of_numbers(1);
  blind.has_truth = false;
  apart.joint_covariance = false;
  for (const RunLayout& layout : {blind, apart, layout_of_numbers(0)}) {
    recorder.begin_run(layout, "unusable");
    recorder.add(step_of_number(1.0, 1.0));
  }
  recorder.begin_run(layout_of_numbers(13), "large");
  recorder.add(step_of_errors(Vector::Ones(13), Matrix::Identity(13, 13)));
  recorder.begin_run(layout_of_numbers(1), "empty");
  recorder.begin_run(layout_of_numbers(2), "kept");
  Step step = step_of_errors(Vector::Ones(2), Matrix::Identity(2, 2));
  recorder.add(step);
  step.problem = "P is not symmetric";
  recorder.add(step);
  recorder.add(step_of_errors(Vector::Ones(2), Matrix{{1.0, 2.0}, {2.0, 1.0}}));
  recorder.add(step_of_errors(Vector{{1.0, kNaN}}, Matrix::Identity(2, 2)));
  recorder.add(step_of_number(1.0, 1.0));
  recorder.rename_run("renamed");
  const std::vector<CalibrationRun> runs = recorder.take();
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0].name, "renamed");
  EXPECT_EQ(runs[0].whole.rows, 1);
  EXPECT_TRUE(runs[0].stretches.empty());
}

TEST(CalibrationUnits, AreTheFirstRunsOfAllRecorders) {
  CalibrationRecorder first, second;
  for (int run = 0; run < 3000; ++run) {
    for (CalibrationRecorder* recorder : {&first, &second}) {
      recorder->begin_run(layout_of_numbers(1), (recorder == &first ? "a" : "b") + std::to_string(run));
      recorder->add(step_of_number(1.0, 1.0));
    }
  }
  CalibrationUnits units;
  units.append(first);
  units.append(second);
  ASSERT_EQ(units.runs.size(), CalibrationRecorder::kMostRuns);
  EXPECT_EQ(units.runs[2999].name, "a2999");
  EXPECT_EQ(units.runs[3000].name, "b0");
  EXPECT_EQ(units.parts.size(), 1U);
  EXPECT_TRUE(first.take().empty());
}

}  // namespace
}  // namespace credence::internal
