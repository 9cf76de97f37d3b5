#include "analysis/evidence/causes/cause_findings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "analysis/evidence/sums/evidence_recorder.h"
#include "analysis/evidence/verdicts/judgement.h"

namespace credence::internal {
namespace {

/// 25 runs of 40 rows of two sensors: NIS of "cut" are uniform up to 1, as none that passed a gate and
/// were scaled besides; those of "fine" are χ². Both have a mean.
Findings findings_of_two(bool cut_first) {
  const Sensor cut{.name = "cut", .dim = 1, .piece = 1}, fine{.name = "fine", .dim = 1, .piece = 1};
  RunLayout layout{.sensors = cut_first ? std::vector{cut, fine} : std::vector{fine, cut}};
  layout.has_truth = false;
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const auto innovation = [](double nu) {
    return Innovation{.nu = Vector::Constant(1, nu), .S = Matrix::Identity(1, 1)};
  };
  for (std::int64_t k = 1; k <= 1000; ++k) {
    if (k % 40 == 1) recorder.begin_run();
    const Innovation a = innovation(std::sqrt(uniform(random)) * (uniform(random) < 0.8 ? 1.0 : -1.0));
    const Innovation b = innovation(normal(random) + 0.3);
    Step step{.step = 1 + (k - 1) % 40};
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

/// 25 runs of 40 rows of a sensor of two components, the second of this variance where 1 is claimed, and one
/// of one component.
Findings findings_of_beacon(double second, double wheel) {
  RunLayout layout{
      .sensors = {{.name = "beacon", .dim = 2, .piece = 2}, {.name = "wheel", .dim = 1, .piece = 1}}};
  layout.has_truth = false;
  EvidenceRecorder recorder(layout);
  std::mt19937_64 random(14);
  std::normal_distribution<double> normal;
  for (std::int64_t k = 1; k <= 1000; ++k) {
    if (k % 40 == 1) recorder.begin_run();
    Step step{.step = 1 + (k - 1) % 40};
    step.innovations = {Innovation{.nu = Eigen::Vector2d(normal(random), std::sqrt(second) * normal(random)),
                                   .S = Matrix::Identity(2, 2)},
                        Innovation{.nu = Vector::Constant(1, std::sqrt(wheel) * normal(random)),
                                   .S = Matrix::Identity(1, 1)}};
    recorder.add(step);
  }
  const Evidence evidence = recorder.take();
  return findings_of(evidence, judge(evidence));
}

TEST(CauseFindings, AComponentIsTheMostWrongPartWhereNoOtherSensorIsMoreWrong) {
  ASSERT_TRUE(findings_of_beacon(1.8, 1.0).wrong_component);
  EXPECT_EQ(findings_of_beacon(1.8, 1.0).wrong_component->sensor, "beacon");
  EXPECT_TRUE(findings_of_beacon(3.0, 1.8).wrong_component);
  EXPECT_FALSE(findings_of_beacon(1.8, 3.0).wrong_component);
  EXPECT_FALSE(findings_of_beacon(1.8, 0.3).wrong_component) << "in either direction";
}

/// One state and a sensor of one component.
RunLayout layout_of_one() {
  RunLayout layout{.states = {"x"}, .angles = {false}, .units = {""}};
  layout.sensors = {Sensor{.name = "z", .dim = 1, .piece = 1}};
  layout.has_truth = true;
  return layout;
}

/// Twenty runs of 40 rows, in every second of which P hardly falls and NIS is far too large; spread: of P
/// over the runs.
std::optional<GateRejection> rejection_of(double spread) {
  EvidenceRecorder recorder(layout_of_one());
  std::mt19937_64 random(12);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 20; ++run) {
    recorder.begin_run();
    double log_P = spread * normal(random);
    for (std::int64_t k = 1; k <= 40; ++k) {
      const bool large = k % 2 == 0;
      log_P -= large ? 0.1 : 1.0 + 0.01 * static_cast<double>(k % 7);
      Step step{.step = k, .states = {0}};
      step.P = Matrix::Constant(1, 1, std::exp(log_P));
      step.error = Vector::Constant(1, std::exp(0.5 * log_P) * normal(random));
      step.innovations = {Innovation{.nu = Vector::Constant(1, (large ? 4.0 : 1.0) * normal(random)),
                                     .S = Matrix::Identity(1, 1)}};
      recorder.add(step);
    }
  }
  const Evidence evidence = recorder.take();
  return findings_of(evidence, judge(evidence)).rejection;
}

TEST(CauseFindings, WhereAllRunsHaveOneCovarianceNothingIsRejected) {
  EXPECT_FALSE(rejection_of(0.0));
  EXPECT_TRUE(rejection_of(0.1));
}

/// 60 runs of 20 rows of a random walk, in the first four of which nothing is measured.
double kept_of(double P0, double Q) {
  EvidenceRecorder recorder(layout_of_one());
  std::mt19937_64 random(13);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 60; ++run) {
    recorder.begin_run();
    double error = std::sqrt(P0) * normal(random), P = P0;
    for (std::int64_t k = 1; k <= 20; ++k) {
      error += std::sqrt(Q) * normal(random);
      P += Q;
      Step step{
          .step = k, .states = {0}, .error = Vector::Constant(1, error), .P = Matrix::Constant(1, 1, P)};
      step.innovations = {
          k > 4 ? Innovation{.nu = Vector::Constant(1, normal(random)), .S = Matrix::Identity(1, 1)}
                : Innovation{}};
      recorder.add(step);
    }
  }
  const Evidence evidence = recorder.take();
  return findings_of(evidence, judge(evidence)).kept_before_innovations;
}

// Squares of an error that Q alone makes are correlated by 1/4 from the first step to the fourth, and their
// logarithms by less; but for five standard errors of 60 runs.
TEST(CauseFindings, WhatP0MadeIsKeptUntilTheFirstInnovation) {
  EXPECT_GT(kept_of(1.0, 1e-6), 0.99);
  EXPECT_LT(kept_of(0.0, 1.0), 0.85);
}

/// One run of 3,000 rows of a random walk in two axes, Q = 0.01, whose R are 1 and 9, and the other way round
/// in the filter.
Findings findings_of_exchanged() {
  RunLayout layout{.sensors = {Sensor{.name = "gnss", .dim = 2, .piece = 2}}};
  layout.has_truth = false;
  EvidenceRecorder recorder(layout);
  recorder.begin_run();
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  const Vector sigma{{1.0, 3.0}}, claimed{{9.0, 1.0}};
  Vector error = Vector::Zero(2), P = Vector::Constant(2, 1.0);
  for (std::int64_t k = 1; k <= 3000; ++k) {
    Innovation innovation{.nu = Vector(2), .S = Matrix::Zero(2, 2)};
    for (Index i = 0; i < 2; ++i) {
      error[i] += 0.1 * normal(random);
      P[i] += 0.01;
      innovation.nu[i] = sigma[i] * normal(random) - error[i];
      innovation.S(i, i) = P[i] + claimed[i];
      const double gain = P[i] / innovation.S(i, i);
      error[i] += gain * innovation.nu[i];
      P[i] *= 1.0 - gain;
    }
    Step step{.step = k};
    step.innovations = {innovation};
    recorder.add(step);
  }
  const Evidence evidence = recorder.take();
  return findings_of(evidence, judge(evidence));
}

// Fixed and float solutions of a receiver are states of their own: no row has all of them.
TEST(CauseFindings, WhyCrossCovariancesWereNotTestedIsSaid) {
  const auto reason = [](std::int64_t runs, bool whole) {
    RunLayout layout{.states = {"fix", "float"}, .angles = {false, false}};
    add_named_blocks(layout);
    EvidenceRecorder recorder(layout);
    for (std::int64_t run = 0; run < runs; ++run) {
      recorder.begin_run();
      for (std::int64_t k = 1; k <= 30; ++k) {
        Step step{.step = k};
        step.states = whole ? std::vector<Index>{0, 1} : std::vector<Index>{k % 2};
        const Index states = std::ssize(step.states);
        step.error = Vector::Constant(states, 0.1 * static_cast<double>(k % 7));
        step.P = Matrix::Identity(states, states);
        recorder.add(step);
      }
    }
    const Evidence evidence = recorder.take();
    const Findings findings = findings_of(evidence, judge(evidence));
    return findings.error_correlation ? std::string(findings.error_correlation->reason) : "no test";
  };
  EXPECT_EQ(reason(12, false), "no row has the errors of all states");
  EXPECT_EQ(reason(2, true), "fewer than 10 runs, and no stretches of them that are independent");
}

TEST(CauseFindings, ComponentsOnBothSidesOfOneAreFoundWithTheirLags) {
  const std::optional<Findings::OpposedComponents> opposed = findings_of_exchanged().opposed_components;
  ASSERT_TRUE(opposed);
  EXPECT_EQ(opposed->large_name, "component 2 of gnss");
  EXPECT_EQ(opposed->small_name, "component 1 of gnss");
  EXPECT_GT(opposed->large.mean, 5.0);
  EXPECT_LT(opposed->small.mean, 0.2);
  // The gain of the small one is 0.03, that of the large one 0.1: lag 1 is −0.1 or less of it, and σ is
  // 0.018.
  EXPECT_LT(opposed->lags, -3.5);
  EXPECT_FALSE(findings_of_two(true).opposed_components);
}

}  // namespace
}  // namespace credence::internal
