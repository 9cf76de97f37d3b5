#include "montecarlo/engine/study_statistics.h"

#include <gtest/gtest.h>

#include <random>

namespace credence::internal {
namespace {

StudyStatistics sample(std::uint64_t seed, std::int64_t runs, std::int64_t first = 0) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  StudyStatistics s;
  s.runs = runs;
  s.steps.resize(3);
  for (std::int64_t r = 0; r < runs; ++r) {
    for (StepStatistics& step : s.steps) {
      for (Moments& m : step.quantities) m.add(normal(rng));
      step.nees_dof += 2;
      step.nis_dof += 1;
    }
  }
  s.failures.push_back({first + runs / 2, 2, Outcome::diverged});
  return s;
}

TEST(Moments, MergingIsAddingAllValues) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal(5.0, 2.0);
  Moments all, left, right;
  for (int i = 0; i < 1000; ++i) {
    const double x = normal(rng);
    all.add(x);
    (i < 300 ? left : right).add(x);
  }
  left.merge(right);
  EXPECT_EQ(left.count, all.count);
  EXPECT_NEAR(left.mean, all.mean, 1e-13);
  EXPECT_NEAR(left.m2 / all.m2, 1.0, 1e-13);
  Moments empty;
  empty.merge(all);
  EXPECT_EQ(empty, all);
  empty.merge({});
  EXPECT_EQ(empty, all);
}

TEST(StudyStatistics, BytesReadBackToTheSame) {
  StudyStatistics s = sample(1, 10);
  EXPECT_EQ(statistics_from_bytes(to_bytes(s)), s);
  EXPECT_LT(static_cast<double>(to_bytes(s).size()), most_stored_bytes(3, 1));
  s.not_converged.push_back({.run = 5, .steps = 1});
  EXPECT_EQ(statistics_from_bytes(to_bytes(s)), s);
  EXPECT_EQ(static_cast<double>(to_bytes(s).size()), most_stored_bytes(3, 1))
      << "3 steps, one run that failed, and had not converged before";
}

// Formats 2 and 3 had ten quantities a step.
TEST(StudyStatistics, BytesOfTheFormatBeforeAreRead) {
  for (const bool all_converged : {true, false}) {
    StudyStatistics s = sample(1, 10);
    if (!all_converged) s.not_converged.push_back({.run = 5, .steps = 1});
    for (StepStatistics& step : s.steps) {
      step[Quantity::heading_variance] = step[Quantity::landmark_variance] = {};
    }
    std::vector<std::byte> bytes = to_bytes(s);
    bytes[0] = static_cast<std::byte>(all_converged ? 2 : 3);
    constexpr std::ptrdiff_t kHead = 20, kMoments = 24, kDofs = 16;
    for (std::ptrdiff_t step = 0; step < 3; ++step) {
      const auto gone = bytes.begin() + kHead + step * (10 * kMoments + kDofs) + 10 * kMoments;
      bytes.erase(gone, gone + 2 * kMoments);
    }
    EXPECT_EQ(statistics_from_bytes(bytes), s);
  }
}

TEST(StudyStatistics, BytesThatAreCutOrChangedAreRefused) {
  const std::vector<std::byte> bytes = to_bytes(sample(1, 10));
  for (std::size_t n = 0; n < bytes.size(); n += 7) {
    EXPECT_THROW(statistics_from_bytes(std::span(bytes).first(n)), std::runtime_error) << n;
  }
  std::vector<std::byte> longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_THROW(statistics_from_bytes(longer), std::runtime_error);
  std::vector<std::byte> huge_count = bytes;
  for (std::size_t i = 12; i < 20; ++i) huge_count[i] = std::byte{0xff};
  EXPECT_THROW(statistics_from_bytes(huge_count), std::runtime_error);
}

TEST(StudyStatistics, CountsOutcomes) {
  StudyStatistics s = sample(1, 10);
  StudyStatistics later = sample(2, 20, 10);
  later.not_converged.push_back({.run = 12, .steps = 2});
  s.merge(later);
  EXPECT_EQ(s.not_converged, later.not_converged);
  EXPECT_EQ(s.runs, 30);
  EXPECT_EQ(s.count(Outcome::ok), 28);
  EXPECT_EQ(s.count(Outcome::diverged), 2);
  EXPECT_EQ(s.count(Outcome::not_positive_definite), 0);
  EXPECT_EQ(s.steps[0].nees_dof, 60);
  EXPECT_EQ(s.steps[0].nis_dof, 30);
  StudyStatistics other;
  EXPECT_THROW(s.merge(other), std::invalid_argument);
}

TEST(StudyStatistics, DofsAreTheSumsOfEveryStep) {
  StudyStatistics statistics;
  statistics.steps.resize(2);
  statistics.steps[0].nees_dof = 6;
  statistics.steps[1].nees_dof = 8;
  statistics.steps[1].nis_dof = 3;
  EXPECT_EQ(statistics.dofs(Quantity::nees), (std::vector<double>{6.0, 8.0}));
  EXPECT_EQ(statistics.dofs(Quantity::nis), (std::vector<double>{0.0, 3.0}));
  EXPECT_THROW(statistics.dofs(Quantity::trace), std::invalid_argument);
}

TEST(FailedText, OneRunIsTheOnlyOne) {
  EXPECT_EQ(failed_text(2, 6), "2 of 6 runs failed");
  EXPECT_EQ(failed_text(1, 1), "the only run failed");
}

}  // namespace
}  // namespace credence::internal
