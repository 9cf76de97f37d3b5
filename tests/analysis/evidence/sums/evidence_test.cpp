#include "analysis/evidence/sums/evidence.h"

#include <gtest/gtest.h>

#include <cmath>

namespace credence::internal {
namespace {

// P(χ²(2) ≤ k²).
double within_of_two(double k) { return 1.0 - std::exp(-0.5 * k * k); }

// P(χ²(1) ≤ k²).
double within_of_one(double k) { return std::erf(k / std::sqrt(2.0)); }

Evidence evidence_of_runs(std::int64_t runs, std::int64_t steps, double nees) {
  Evidence evidence;
  evidence.study.runs = runs;
  evidence.rows = runs * steps;
  BlockSums& pose = evidence.block({"pose", Part::pose, {0, 1}});
  SensorSums& range = evidence.sensor({.name = "range", .dim = 1, .piece = 1});
  for (std::int64_t k = 0; k < steps; ++k) {
    StepSums sums;
    for (std::int64_t run = 0; run < runs; ++run) sums.add(nees + static_cast<double>(k), 2);
    pose.nees.push_back(sums);
    range.nis.push_back(sums);
    evidence.clean_nees.push_back(sums);
    evidence.study.steps.emplace_back().nees_dof = 2 * runs + k;
  }
  return evidence;
}

TEST(CoverageSums, CountTheEdgeAsInsideAndExpectByDof) {
  CoverageSums sums;
  sums.add(2, 4.0, 2);        // the edge of 2σ
  sums.add(2, 4.0000001, 1);  // just beyond it
  CoverageSums later;
  later.add(3, 0.5, 2);
  sums.merge(later);
  for (std::size_t i = 0; i < CoverageSums::kSigmas.size(); ++i) {
    const CoverageSums::Region& region = sums.regions[i];
    const double k = CoverageSums::kSigmas[i];
    ASSERT_EQ(region.count.size(), 3U);
    EXPECT_EQ(region.count[0], CoverageCount{});
    EXPECT_EQ(region.count[1], (CoverageCount{.inside = static_cast<std::int64_t>(i), .total = 2}));
    EXPECT_EQ(region.count[2], (CoverageCount{.inside = 1, .total = 1}));
    EXPECT_NEAR(region.expected[1], within_of_two(k) + within_of_one(k), 1e-12);
    EXPECT_NEAR(region.expected[2], within_of_two(k), 1e-12);
  }
  sums.drop_every_second_step();
  ASSERT_EQ(sums.regions[0].count.size(), 2U);
  EXPECT_EQ(sums.regions[0].count[1].total, 1);
  EXPECT_NEAR(sums.regions[0].expected[1], within_of_two(1.0), 1e-12);
}

TEST(SensorSums, OfPiecesThatDifferAreFollowedByTheirSumAlone) {
  EXPECT_FALSE(SensorSums({.name = "", .dim = 12, .piece = 12}).varies);
  const SensorSums large({.name = "", .dim = 13, .piece = 13});
  EXPECT_TRUE(large.varies);
  EXPECT_EQ(large.lags.dim(), 1);

  SensorSums sums({.name = "", .dim = 4, .piece = 2});
  EXPECT_EQ(sums.lags.dim(), 2);
  SensorSums same = sums, other({.name = "", .dim = 6, .piece = 3});
  sums.values.add(Vector::Ones(2));
  same.values.add(Vector::Zero(2));
  same.largest_nis = 3.0;
  same.unwrapped = 2;
  sums.merge(same);
  EXPECT_FALSE(sums.varies);
  EXPECT_EQ(sums.values.mean, Vector::Constant(2, 0.5));
  EXPECT_EQ(sums.largest_nis, 3.0);
  other.values.add(Vector::Ones(3));
  other.scalar_values.add(Vector::Constant(1, 7.0));
  other.by_dimension[6].add(5.0, 6);
  other.unwrapped = 1;
  sums.merge(other);
  EXPECT_TRUE(sums.varies);
  EXPECT_EQ(sums.sensor.dim, 6);
  EXPECT_EQ(sums.values.count, 2);  // of three dimensions nothing is added
  EXPECT_EQ(sums.scalar_values.mean, Vector::Constant(1, 7.0));
  EXPECT_EQ(sums.by_dimension.at(6).dof, 6);
  EXPECT_EQ(sums.largest_nis, 3.0);
  EXPECT_EQ(sums.unwrapped, 3);
}

TEST(RunSums, KeepTheFirstRunsInTheirOrder) {
  RunSums sums, later;
  for (std::size_t i = 0; i < RunSums::kKept - 1; ++i) sums.nees.push_back({1.0});
  later.nees = {{2.0}, {3.0, 80.0}};
  later.further = {{.mean = 7.0, .rows = 9}};
  later.last_error = {Vector::Constant(1, 4.0)};
  sums.last_whitened.add(Vector::Ones(2));
  later.last_whitened.add(Vector::Ones(3));
  sums.merge(later, 3.0);
  ASSERT_EQ(sums.nees.size(), RunSums::kKept);
  EXPECT_EQ(sums.nees.back(), std::vector<double>{2.0});
  ASSERT_EQ(sums.further.size(), 2U);  // of the others how they went
  EXPECT_EQ(sums.further[0].mean, 41.5);
  EXPECT_EQ(sums.further[0].first, 2);
  EXPECT_EQ(sums.further[1].mean, 7.0);
  EXPECT_EQ(sums.courses(3.0).size(), RunSums::kKept + 2);
  ASSERT_EQ(sums.last_error.size(), 1U);
  EXPECT_EQ(sums.last_error[0][0], 4.0);
  EXPECT_EQ(sums.last_whitened.count, 1);  // one of another dimension is left out
}

TEST(Evidence, OfLaterRunsAddsUpAndNumbersThemOn) {
  Evidence first = evidence_of_runs(3, 2, 1.0), later = evidence_of_runs(1, 3, 5.0);
  first.first_run = {1.0, 1.0};
  first.rejected["P is not symmetric"] = {.count = 2, .first = "a.csv:7"};
  later.rejected["P is not symmetric"] = {.count = 1, .first = "b.csv:1"};
  later.rejected["no truth"] = {.count = 4, .first = "b.csv:2"};
  first.wrongly_certain["z"] = {.count = 2, .first = "a.csv:8"};
  later.wrongly_certain = {{"z", {.count = 3, .first = "b.csv:3"}},
                           {"roll", {.count = 1, .first = "b.csv:4"}}};
  later.study.failures = {{.run = 0, .step = 3, .outcome = Outcome::diverged}};
  later.block({"map", Part::map, {2}}).squared_error.add(9.0);
  later.narrow_angles = {.inside = 1, .total = 2};
  later.state_dim = 5;
  later.joint_covariance = false;
  later.has_truth = true;
  later.sensor_pair("range", "bearing", 1).both.add(Vector::Ones(2));
  first.merge(later);
  EXPECT_EQ(first.study.runs, 4);
  EXPECT_EQ(first.rows, 9);
  ASSERT_EQ(first.study.failures.size(), 1U);
  EXPECT_EQ(first.study.failures[0].run, 3);
  ASSERT_EQ(first.study.steps.size(), 3U);
  EXPECT_EQ(first.study.steps[1].nees_dof, 7 + 3);
  EXPECT_EQ(first.study.steps[2].nees_dof, 4);
  ASSERT_EQ(first.blocks.size(), 2U);
  EXPECT_EQ(first.blocks[0].nees[1].dof, 8);
  EXPECT_NEAR(first.blocks[0].nees[1].value.mean, (3.0 * 2.0 + 6.0) / 4.0, 1e-14);
  EXPECT_EQ(first.blocks[1].part, Part::map);
  EXPECT_EQ(first.blocks[1].squared_error.mean, 9.0);
  ASSERT_EQ(first.sensors.size(), 1U);
  EXPECT_EQ(first.sensors[0].nis[2].value.count, 1);
  EXPECT_EQ(first.sensor_pair("range", "bearing", 1).both.count, 1);
  EXPECT_EQ(first.rejected_rows(), 7);
  EXPECT_EQ(first.rejected.at("P is not symmetric").first, "a.csv:7");
  EXPECT_EQ(first.rejected.at("no truth").first, "b.csv:2");
  EXPECT_EQ(first.wrongly_certain_rows(), 5);
  EXPECT_EQ(first.wrongly_certain.at("z").first, "a.csv:8");
  EXPECT_EQ(first.wrongly_certain.at("roll").first, "b.csv:4");
  EXPECT_TRUE(first.first_run.empty());
  EXPECT_EQ(first.narrow_angles, (CoverageCount{.inside = 1, .total = 2}));
  EXPECT_EQ(first.state_dim, 5);
  EXPECT_FALSE(first.joint_covariance);
  EXPECT_TRUE(first.has_truth);
}

TEST(Evidence, OfNoRunsChangesNothing) {
  Evidence evidence = evidence_of_runs(1, 2, 1.0);
  evidence.first_run = {0.5, 1.0};
  Evidence empty;
  empty.joint_covariance = false;
  evidence.merge(empty);
  EXPECT_TRUE(evidence.joint_covariance);
  EXPECT_EQ(evidence.first_run.size(), 2U);
  empty.merge(evidence);
  EXPECT_TRUE(empty.joint_covariance);  // becomes the other as a whole
  EXPECT_EQ(empty.first_run, (std::vector<double>{0.5, 1.0}));
}

TEST(Evidence, OfDifferentStridesMeetsAtTheCoarserOne) {
  Evidence fine = evidence_of_runs(1, 5, 0.0), coarse = evidence_of_runs(1, 2, 10.0);
  coarse.step_stride = 2;  // of steps 1 and 3
  fine.merge(coarse);
  EXPECT_EQ(fine.step_stride, 2);
  ASSERT_EQ(fine.clean_nees.size(), 3U);  // steps 1, 3 and 5
  EXPECT_NEAR(fine.clean_nees[1].value.mean, 0.5 * (2.0 + 11.0), 1e-14);
  EXPECT_EQ(fine.clean_nees[2].value.mean, 4.0);
  EXPECT_NEAR(fine.sensors[0].nis[1].value.mean, 6.5, 1e-14);
  coarse.joint_covariance = false;
  coarse.merge(evidence_of_runs(1, 5, 0.0));
  ASSERT_EQ(coarse.clean_nees.size(), 3U);
  EXPECT_NEAR(coarse.clean_nees[1].value.mean, 6.5, 1e-14);
  EXPECT_FALSE(coarse.joint_covariance);
  fine.thin_steps(4 * (std::int64_t{1} << 17));  // 2^17 steps are kept
  EXPECT_EQ(fine.step_stride, 4);
  fine.thin_steps(4 * (std::int64_t{1} << 17) + 1);
  EXPECT_EQ(fine.step_stride, 8);
  EXPECT_EQ(fine.blocks[0].nees.size(), 1U);
}

}  // namespace
}  // namespace credence::internal
