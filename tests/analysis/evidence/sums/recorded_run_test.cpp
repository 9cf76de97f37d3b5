#include "analysis/evidence/sums/recorded_run.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"

namespace credence::internal {
namespace {

/// White innovations with true variances `scale` times those that the filter claims.
RecordedInnovations white_innovations(int count, double scale, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, std::sqrt(scale));
  RecordedInnovations run;
  for (int i = 0; i < count; ++i) {
    run.whitened.emplace_back(Eigen::Vector2d(normal(random), normal(random)));
    run.nis.push_back(run.whitened.back().squaredNorm());
  }
  return run;
}

// Holm's adjustment keeps the chance that any of the four tests rejects at 5 %, and the interval of the scale
// covers 1 in 95 % of all recordings; 5 standard errors of the binomial counts.
TEST(RecordedInnovations, FalseAlarmsAreAsRareAsTheyShouldBe) {
  constexpr int kRecordings = 200;
  int alarms = 0, misses = 0;
  for (unsigned seed = 0; seed < kRecordings; ++seed) {
    const InnovationTests tests =
        test_recorded_innovations(std::vector{white_innovations(300, 1.0, seed)}, 0.95);
    const auto& p = tests.adjusted_p_value;
    alarms += *std::min_element(p.begin(), p.end()) <= 0.05 ? 1 : 0;
    misses += tests.noise_scale.lower > 1.0 || tests.noise_scale.upper < 1.0 ? 1 : 0;
  }
  const double most = 0.05 * kRecordings + 5 * std::sqrt(0.05 * 0.95 * kRecordings);
  EXPECT_LE(alarms, most);
  EXPECT_LE(misses, most);
  EXPECT_GT(alarms + misses, 0) << "a test that never rejects tells nothing";
}

// Var(NIS/2) = 1 for 2 dof, so the scale's standard error is scale/√N.
TEST(RecordedInnovations, FindTheScaleOfTheNoise) {
  for (const double scale : {0.07, 4.0}) {
    const InnovationTests tests =
        test_recorded_innovations(std::vector{white_innovations(2000, scale, 2)}, 0.95);
    EXPECT_NEAR(tests.noise_scale.scale, scale, 5 * scale / std::sqrt(2000.0));
    EXPECT_LT(tests.noise_scale.lower, scale * 1.02);
    EXPECT_GT(tests.noise_scale.upper, scale * 0.98);
    EXPECT_EQ(tests.nis.verdict, scale < 1 ? Verdict::pessimistic : Verdict::optimistic);
    EXPECT_LT(tests.adjusted_p_value[1], 1e-6) << "the law";
    EXPECT_TRUE(tests.whiteness.white) << "a scale is no correlation";
  }
}

/// Those within a gate, as a filter would have kept them.
RecordedInnovations gated(RecordedInnovations run, double gate) {
  run.gate = gate;
  std::erase_if(run.nis, [&](double x) { return x > gate; });
  std::erase_if(run.whitened, [&](const Vector& u) { return u.squaredNorm() > gate; });
  return run;
}

TEST(RecordedInnovations, WithinAGateFollowTheTruncatedLaw) {
  const double gate = chi_square_quantile(0.9, 2);  // a narrow one, that the plain law would not survive
  const InnovationTests right =
      test_recorded_innovations(std::vector{gated(white_innovations(4000, 1, 3), gate)}, 0.95);
  EXPECT_EQ(right.nis.verdict, Verdict::consistent);
  EXPECT_GT(right.adjusted_p_value[1], 0.05);
  EXPECT_LT(right.nis.expected, 1.6);
  const InnovationTests wrong =
      test_recorded_innovations(std::vector{gated(white_innovations(4000, 0.5, 4), gate)}, 0.95);
  EXPECT_EQ(wrong.nis.verdict, Verdict::pessimistic);
  EXPECT_NEAR(wrong.noise_scale.scale, 0.5, 0.05) << "the cut is undone";
  EXPECT_LT(wrong.noise_scale.lower, 0.5 * 1.03);
  EXPECT_GT(wrong.noise_scale.upper, 0.5 * 0.97);
}

TEST(RecordedInnovations, ABiasAndCorrelationAreFound) {
  RecordedInnovations biased = white_innovations(2000, 1, 5), coloured = white_innovations(2000, 1, 6);
  for (Vector& u : biased.whitened) u(1) += 0.3;
  EXPECT_LT(test_recorded_innovations(std::vector{biased}, 0.95).adjusted_p_value[3], 1e-3);
  for (std::size_t i = 1; i < coloured.whitened.size(); ++i)
    coloured.whitened[i] = 0.8 * coloured.whitened[i - 1] + 0.6 * coloured.whitened[i];
  const InnovationTests tests = test_recorded_innovations(std::vector{coloured}, 0.95);
  EXPECT_FALSE(tests.whiteness.white);
  EXPECT_NEAR(tests.whiteness.autocorrelation[0], 0.8, 0.1);
  EXPECT_GT(tests.mean_p_value, 1e-3) << "correlation alone is no bias";
}

TEST(RecordedInnovations, SlowOnesHaveAWideInterval) {
  RecordedInnovations slow = white_innovations(900, 1, 8);
  for (std::size_t i = 1; i < slow.whitened.size(); ++i)
    slow.whitened[i] = 0.97 * slow.whitened[i - 1] + std::sqrt(1 - 0.97 * 0.97) * slow.whitened[i];
  for (std::size_t i = 0; i < slow.nis.size(); ++i) slow.nis[i] = slow.whitened[i].squaredNorm();
  const NoiseScale wide = test_recorded_innovations(std::vector{slow}, 0.95).noise_scale;
  const NoiseScale narrow =
      test_recorded_innovations(std::vector{white_innovations(900, 1, 8)}, 0.95).noise_scale;
  EXPECT_EQ(wide.stretches, 5);
  EXPECT_EQ(narrow.stretches, 50);
  EXPECT_GT(wide.upper - wide.lower, 3 * (narrow.upper - narrow.lower));
}

/// Of a white one, each value as long as so many; the mean NIS is `scale` times the expected one.
RecordedInnovations lasting_innovations(int count, int each, double scale, unsigned seed) {
  const RecordedInnovations white = white_innovations(count / each, scale, seed);
  RecordedInnovations run;
  for (int i = 0; i < count / each * each; ++i) {
    run.nis.push_back(white.nis[static_cast<std::size_t>(i / each)]);
    run.whitened.push_back(white.whitened[static_cast<std::size_t>(i / each)]);
  }
  return run;
}

// Whatever the runs: those that linger cannot be cut into many stretches and count all the same, and so does
// the end of a run that does not divide into stretches of one length.
TEST(RecordedInnovations, TheScaleLiesWithinItsInterval) {
  for (const unsigned runs : {1U, 3U, 8U, 20U}) {
    std::vector<RecordedInnovations> all;
    for (unsigned i = 0; i < runs; ++i) {
      all.push_back(i % 4 == 1 ? lasting_innovations(119, 30, 50.0, 40 + i) : white_innovations(119, 1.0, i));
    }
    for (auto value = all.front().nis.end() - 17; value != all.front().nis.end(); ++value) *value *= 9.0;
    const NoiseScale scale = test_recorded_innovations(all, 0.95).noise_scale;
    if (!scale.reason.empty()) continue;
    EXPECT_LT(scale.lower, scale.scale) << runs << " runs";
    EXPECT_GT(scale.upper, scale.scale) << runs << " runs";
  }
}

// Runs whose covariances are wrong by factors of their own, 1/2 and an exponential variable, 1.5 in the mean.
TEST(RecordedInnovations, TheIntervalIsOfFurtherRunsToo) {
  constexpr int kRecordings = 200;
  std::mt19937_64 random(17);
  std::exponential_distribution<double> exponential;
  int misses = 0;
  for (unsigned recording = 0; recording < kRecordings; ++recording) {
    std::vector<RecordedInnovations> runs;
    for (unsigned i = 0; i < 30; ++i) {
      runs.push_back(white_innovations(50, 0.5 + exponential(random), 1000 + 30 * recording + i));
    }
    const NoiseScale scale = test_recorded_innovations(runs, 0.95).noise_scale;
    misses += scale.lower > 1.5 || scale.upper < 1.5 ? 1 : 0;
  }
  EXPECT_LE(misses, 0.05 * kRecordings + 5 * std::sqrt(0.05 * 0.95 * kRecordings));
}

TEST(RecordedInnovations, TooShortARecordingHasNoInterval) {
  const InnovationTests tests = test_recorded_innovations(std::vector{white_innovations(10, 1, 7)}, 0.95);
  EXPECT_FALSE(tests.noise_scale.reason.empty());
  EXPECT_TRUE(std::isnan(tests.noise_scale.lower));
  const InnovationTests none = test_recorded_innovations(std::vector{RecordedInnovations{}}, 0.95);
  EXPECT_EQ(none.nis.verdict, Verdict::undecided);
  EXPECT_THROW(test_recorded_innovations({}, 0.95), std::invalid_argument);
  std::vector<RecordedInnovations> differ(2);
  differ[1].gate = 9;
  EXPECT_THROW(test_recorded_innovations(differ, 0.95), std::invalid_argument);
}

RecordedNees constant_nees(double value, int count) {
  RecordedNees run;
  for (int i = 0; i < count; ++i) {
    run.time_s.push_back(0.25 * i);
    run.nees.push_back(value);
  }
  return run;
}

TEST(RecordedNees, IsAveragedOverTheRunsInEveryInterval) {
  const std::vector<RecordedNees> runs{constant_nees(2, 40), constant_nees(4, 20)};
  const RecordedNeesVerdict result = judge_recorded_nees(runs, 3, 1.0, 0.95);
  ASSERT_EQ(result.verdict.steps.size(), 10U);
  EXPECT_EQ(result.verdict.steps[4].count, 2);
  EXPECT_DOUBLE_EQ(result.verdict.steps[4].mean, 3);
  EXPECT_EQ(result.verdict.steps[5].count, 1);
  EXPECT_DOUBLE_EQ(result.verdict.steps[5].mean, 2);
  EXPECT_EQ(result.verdict.verdict, Verdict::consistent);
  EXPECT_EQ(result.run_mean, (std::vector<double>{2, 4}));
  EXPECT_EQ(judge_recorded_nees(std::vector{constant_nees(60, 40)}, 3, 1.0, 0.95).verdict.verdict,
            Verdict::optimistic);
  EXPECT_THROW(judge_recorded_nees(runs, 0, 1.0, 0.95), std::invalid_argument);
  EXPECT_THROW(judge_recorded_nees(runs, 3, 0.0, 0.95), std::invalid_argument);
}

/// A map of ten points with a random joint covariance, and an error drawn from it.
struct MapCase {
  Vector truth, error;
  Matrix P;
};

MapCase map_case(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  constexpr Index n = 20;
  MapCase c{Vector(n), Vector(n), Matrix(n, n)};
  Matrix A(n, n);
  Vector w(n);
  for (Index i = 0; i < n; ++i) {
    c.truth(i) = 10 * normal(random);
    w(i) = normal(random);
    for (Index j = 0; j < n; ++j) A(i, j) = 1e-3 * normal(random);
  }
  c.P = A * A.transpose() + 1e-6 * Matrix::Identity(n, n);
  c.error = Eigen::LLT<Matrix>(c.P).matrixL() * w;
  return c;
}

// E = dof, Var = 2 dof for a sum of independent χ².
TEST(MapConsistency, IsChiSquareForAnErrorFromItsCovariance) {
  double placed = 0, shape = 0;
  constexpr int kMaps = 200;
  for (unsigned seed = 0; seed < kMaps; ++seed) {
    const MapCase c = map_case(seed);
    const MapConsistency result = judge_map(c.truth + c.error, c.truth, c.truth, c.P);
    ASSERT_TRUE(result.placed.ok && result.shape.ok);
    EXPECT_EQ(result.placed.dof, 20);
    EXPECT_EQ(result.shape.dof, 17);
    placed += result.placed.value;
    shape += result.shape.value;
  }
  EXPECT_NEAR(placed, 20 * kMaps, 5 * std::sqrt(2.0 * 20 * kMaps));
  EXPECT_NEAR(shape, 17 * kMaps, 5 * std::sqrt(2.0 * 17 * kMaps));
}

TEST(MapConsistency, TheShapeDoesNotDependOnWhereTheMapLies) {
  const MapCase c = map_case(1);
  const MapConsistency here = judge_map(c.truth + c.error, c.truth, c.truth, c.P);
  // The same map turned by 40° and moved, with its covariance turned as well.
  const Eigen::Rotation2Dd turn(0.7);
  const Vector shift = Eigen::Vector2d(3, -5).replicate(10, 1);
  Matrix T = Matrix::Zero(20, 20);
  for (Index i = 0; i < 20; i += 2) T.block<2, 2>(i, i) = turn.toRotationMatrix();
  const MapConsistency there =
      judge_map(T * (c.truth + c.error) + shift, c.truth, T * c.truth + shift, T * c.P * T.transpose());
  EXPECT_NEAR(there.shape.value, here.shape.value, 1e-6 * here.shape.value);
  EXPECT_GT(there.placed.value, 1e3 * here.placed.value);
  EXPECT_LT(there.placed_p_value, 1e-6);
}

TEST(MapConsistency, OfTooFewPointsHasNoShape) {
  const Vector four = Vector::Ones(4);
  const MapConsistency two = judge_map(four, four, four, Matrix::Identity(4, 4));
  EXPECT_TRUE(two.placed.ok);
  EXPECT_FALSE(two.shape.ok);
  EXPECT_TRUE(std::isnan(two.shape_p_value));
  EXPECT_FALSE(judge_map(Vector(), Vector(), Vector(), Matrix()).placed.ok);
  EXPECT_THROW(judge_map(four, four, Vector::Ones(6), Matrix::Identity(4, 4)), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
