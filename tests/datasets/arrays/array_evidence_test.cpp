#include "datasets/arrays/array_evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <vector>

#include "analysis/evidence/sums/evidence_recorder.h"
#include "core/manifold/angle.h"
#include "montecarlo/random/noise.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kStudyRuns = 150, kStudySteps = 12;
constexpr Index kStates = 3, kMeasurements = 2;

/// Errors N(0, P) and innovations N(0, S), laid out as a user has them.
class ArrayEvidence : public ::testing::Test {
 protected:
  ArrayEvidence() {
    const NoiseSource noise(5, 0);
    for (std::int64_t run = 0; run < kStudyRuns; ++run) {
      for (std::int64_t k = 1; k <= kStudySteps; ++k) {
        std::vector<double> e(kStates + kMeasurements);
        noise.normals(run, k, NoisePurpose::measurement, e);
        error_.insert(error_.end(), e.begin(), e.begin() + kStates);
        nu_.insert(nu_.end(), e.begin() + kStates, e.end());
        for (Index i = 0; i < kStates * kStates; ++i) P_.push_back(i % (kStates + 1) == 0 ? 1.0 : 0.0);
        S_.insert(S_.end(), {1.0, 0.0, 0.0, 1.0});
      }
    }
    arrays_.layout.states = {"pose.x", "pose.y", "heading"};
    arrays_.layout.angles = {false, false, true};
    add_named_blocks(arrays_.layout);
    arrays_.layout.sensors.push_back({.name = "gps", .dim = kMeasurements, .piece = kMeasurements});
  }

  const ArrayRuns& arrays() {
    arrays_.runs.clear();
    for (std::int64_t run = 0; run < kStudyRuns; ++run) {
      ArrayRun& of = arrays_.runs.emplace_back();
      of.steps = kStudySteps;
      of.error = rows(error_, run, kStates);
      of.P = rows(P_, run, kStates * kStates);
      of.innovations.push_back({rows(nu_, run, kMeasurements), rows(S_, run, kMeasurements * kMeasurements)});
    }
    return arrays_;
  }

  static ArrayRows rows(const std::vector<double>& values, std::int64_t run, Index row) {
    return {values.data() + run * kStudySteps * row, row};
  }

  static std::size_t at(std::int64_t run, std::int64_t step, Index row, Index i) {
    return static_cast<std::size_t>((run * kStudySteps + step) * row + i);
  }

  std::string complaint() {
    try {
      add_arrays(arrays(), 1);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "none";
  }

  ArrayRuns arrays_;
  std::vector<double> error_, P_, nu_, S_;
};

TEST_F(ArrayEvidence, IsThatOfTheSameSteps) {
  error_[at(70, 3, kStates, 1)] = std::numeric_limits<double>::quiet_NaN();
  nu_[at(70, 4, kMeasurements, 0)] = std::numeric_limits<double>::quiet_NaN();
  const Evidence got = add_arrays(arrays(), 2);

  Evidence wanted;
  EvidenceRecorder recorder(arrays_.layout);
  for (std::int64_t run = 0; run < kStudyRuns; ++run) {
    recorder.begin_run();
    for (std::int64_t k = 0; k < kStudySteps; ++k) {
      Step step{.step = k + 1};
      for (Index i = 0; i < kStates; ++i) {
        if (!(run == 70 && k == 3 && i == 1)) step.states.push_back(i);
      }
      const Index n = std::ssize(step.states);
      step.error.resize(n);
      step.P = Matrix::Identity(n, n);
      for (Index i = 0; i < n; ++i) {
        const Index state = step.states[static_cast<std::size_t>(i)];
        step.error[i] = error_[at(run, k, kStates, state)];
        if (state == 2) step.error[i] = wrap_angle(step.error[i]);
      }
      const Index from = run == 70 && k == 4 ? 1 : 0;
      Innovation seen{Vector(kMeasurements - from),
                      Matrix::Identity(kMeasurements - from, kMeasurements - from)};
      for (Index i = from; i < kMeasurements; ++i) seen.nu[i - from] = nu_[at(run, k, kMeasurements, i)];
      step.innovations.push_back(seen);
      recorder.add(step);
    }
  }
  for (Evidence& chunk : recorder.take_chunks()) wanted.merge(std::move(chunk));
  wanted.merge(recorder.take());

  EXPECT_EQ(got.study, wanted.study);
  EXPECT_EQ(got.rows, kStudyRuns * kStudySteps);
  ASSERT_EQ(got.blocks.size(), 2U);
  for (std::size_t b = 0; b < 2; ++b) EXPECT_EQ(got.blocks[b].nees, wanted.blocks[b].nees);
  EXPECT_EQ(got.sensors.front().nis, wanted.sensors.front().nis);
  EXPECT_EQ(got.sensors.front().by_dimension.size(), 2U);
}

TEST_F(ArrayEvidence, DoesNotDependOnThreads) {
  EXPECT_EQ(add_arrays(arrays(), 1).study, add_arrays(arrays(), 3).study);
}

TEST_F(ArrayEvidence, WrapsAngles) {
  const StudyStatistics plain = add_arrays(arrays()).study;
  error_[at(9, 9, kStates, 2)] += 2.0 * std::numbers::pi;
  const double mean = add_arrays(arrays()).study.steps[9][Quantity::nees].mean;
  EXPECT_NEAR(mean, plain.steps[9][Quantity::nees].mean, 1e-12);
}

TEST_F(ArrayEvidence, CountsAFailedRunUpToItsFailure) {
  arrays();
  arrays_.runs[65].steps = 4;
  arrays_.runs[65].failure = RunFailure{.run = 65, .step = 5, .outcome = Outcome::diverged};
  const Evidence evidence = add_arrays(arrays_);
  ASSERT_EQ(evidence.study.failures.size(), 1U);
  EXPECT_EQ(evidence.study.failures.front(), (RunFailure{65, 5, Outcome::diverged}));
  EXPECT_EQ(evidence.study.steps[3][Quantity::nees].count, kStudyRuns);
  EXPECT_EQ(evidence.study.steps[4][Quantity::nees].count, kStudyRuns - 1);
}

TEST_F(ArrayEvidence, CountsWhatIsNoCovariance) {
  P_[at(80, 2, kStates * kStates, 4)] = -1.0;
  const Evidence evidence = add_arrays(arrays());
  EXPECT_EQ(evidence.rejected_rows(), 1);
  EXPECT_EQ(evidence.rejected.begin()->second.first, "run 80:3");
}

TEST_F(ArrayEvidence, NamesTheFirstBadNumber) {
  EXPECT_EQ(complaint(), "none");
  P_[at(3, 7, kStates * kStates, 1)] = 1.0;
  EXPECT_EQ(complaint(), "P[3, 7] is not symmetric: its entries [0, 1] and [1, 0] are 1 and 0");
  arrays_.indexing = ArrayIndexing::listed;
  EXPECT_THAT(complaint(), HasSubstr("P[3][7] is not symmetric"));
  error_[at(3, 6, kStates, 2)] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(complaint(), "error[3][6, 2] is inf");
  S_[at(2, 0, kMeasurements * kMeasurements, 3)] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(complaint(), "S['gps'][2][0, 1, 1] is nan");
}

TEST(ArrayRunsWithoutSteps, AreNothingToJudge) {
  EXPECT_THROW(add_arrays(ArrayRuns{}), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
