#include "analysis/evidence/causes/cause_findings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "analysis/evidence/sums/evidence_recorder.h"
#include "analysis/evidence/verdicts/judgement.h"

namespace credence::internal {
namespace {

/// One run of 1,000 rows of two sensors: NIS of "cut" are uniform up to 1, as none that passed a gate and
/// were scaled besides; those of "fine" are χ². Both have a mean.
Findings findings_of_two(bool cut_first) {
  const Sensor cut{.name = "cut", .dim = 1, .piece = 1}, fine{.name = "fine", .dim = 1, .piece = 1};
  RunLayout layout{.sensors = cut_first ? std::vector{cut, fine} : std::vector{fine, cut}};
  layout.has_truth = false;
  EvidenceRecorder recorder(layout);
  recorder.begin_run();
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const auto innovation = [](double nu) {
    return Innovation{.nu = Vector::Constant(1, nu), .S = Matrix::Identity(1, 1)};
  };
  for (std::int64_t k = 1; k <= 1000; ++k) {
    const Innovation a = innovation(std::sqrt(uniform(random)) * (uniform(random) < 0.8 ? 1.0 : -1.0));
    const Innovation b = innovation(normal(random) + 0.3);
    Step step{.step = k};
    step.innovations = cut_first ? std::vector{a, b} : std::vector{b, a};
    recorder.add(step);
  }
  const Evidence evidence = recorder.take();
  return findings_of(evidence, judge(evidence));
}

TEST(CauseFindings, WhatASensorTellsIsNotTakenBackByOneThatComesLater) {
  const Findings first = findings_of_two(true), last = findings_of_two(false);
  ASSERT_TRUE(first.cut_off);
  ASSERT_TRUE(last.cut_off);
  EXPECT_EQ(first.cut_off->expected, last.cut_off->expected);
  ASSERT_TRUE(first.innovation_mean);
  ASSERT_TRUE(last.innovation_mean);
  EXPECT_EQ(first.innovation_mean->mean, last.innovation_mean->mean) << "of the smaller p-value";
  EXPECT_EQ(first.rejection.has_value(), last.rejection.has_value());
}

}  // namespace
}  // namespace credence::internal
