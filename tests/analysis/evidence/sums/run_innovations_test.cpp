#include "analysis/evidence/sums/run_innovations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "analysis/evidence/sums/evidence_bytes.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

NormalisedInnovation scalar(double u) {
  NormalisedInnovation innovation;
  innovation.value = u * u;
  innovation.dof = 1;
  innovation.nu = innovation.whitened = Vector::Constant(1, u);
  return innovation;
}

/// At every so many steps of a run an innovation, +1 and −1 in turn.
RunInnovations in_turn(const Sensor& sensor, std::size_t steps, std::size_t interval) {
  RunInnovations run;
  double u = 1.0;
  for (std::size_t k = 0; k < steps; ++k) {
    run.begin_step();
    if (k % interval != 0) continue;
    run.add(sensor, scalar(u), kNaN, kNaN);
    u = -u;
  }
  return run;
}

RunLayout layout_of(std::initializer_list<const char*> sensors) {
  RunLayout layout;
  for (const char* name : sensors) layout.sensors.push_back({.name = name, .dim = 1, .piece = 1});
  return layout;
}

TEST(RunInnovations, AnotherRunHasNothingOfTheOneBefore) {
  RunLayout layout;
  layout.sensors = {{.name = "a", .dim = 2, .piece = 2}};
  const Sensor& sensor = layout.sensors.front();
  NormalisedInnovation innovation = scalar(1.0);  // one number of two: no pieces can be taken apart
  RunInnovations first, again;
  again.begin_step();
  again.add(sensor, innovation, kNaN, kNaN);
  again.begin_run();
  innovation.dof = 2;
  innovation.complete = true;
  innovation.nu = innovation.whitened = Vector{{1.0, -2.0}};
  innovation.variance = Vector::Ones(2);
  innovation.covariance = Vector::Zero(1);
  for (int k = 0; k < 10; ++k) {
    for (RunInnovations* run : {&first, &again}) {
      run->begin_step();
      run->add(sensor, innovation, kNaN, kNaN);
    }
  }
  Evidence of_first, of_again;
  add_innovations_of_run({&first, 1}, layout, of_first);
  add_innovations_of_run({&again, 1}, layout, of_again);
  EXPECT_GT(of_first.sensor(sensor).values.count, 0);
  EXPECT_EQ(to_bytes(of_again), to_bytes(of_first));
}

TEST(RunInnovations, OfAStepAreThoseThatItHas) {
  const Sensor sensor{.name = "a", .dim = 1, .piece = 1};
  const RunInnovations run = in_turn(sensor, 4, 2);
  ASSERT_EQ(run.steps(), 4U);
  ASSERT_EQ(run.at(0).size(), 1U);
  EXPECT_EQ(run.at(0)[0], 1.0);
  EXPECT_TRUE(run.at(1).empty());
  EXPECT_EQ(run.at(2)[0], -1.0);
  EXPECT_TRUE(run.at(3).empty());
}

// +1 and −1 in turn are as correlated at lag 1 as can be, at whatever interval the sensor speaks; the first
// fifth of the run is left out.
TEST(RunInnovations, LagsAreCountedInInnovationsNotInSteps) {
  for (const std::size_t interval : {1U, 3U}) {
    const RunLayout layout = layout_of({"a"});
    const RunInnovations run = in_turn(layout.sensors[0], 50 * interval, interval);
    Evidence sums;
    add_innovations_of_run({&run, 1}, layout, sums);
    const SensorSums& of_sensor = sums.sensor(layout.sensors[0]);
    EXPECT_EQ(of_sensor.lags.of_values().pairs(0), 40) << interval;
    EXPECT_EQ(of_sensor.lags.of_values().pairs(1), 39) << interval;
    EXPECT_DOUBLE_EQ(of_sensor.lags.of_values().product(1)(0, 0), -39.0) << interval;
    EXPECT_EQ(of_sensor.by_dimension.at(1).value.count, 50) << "of the law none is left out";
  }
}

// A gate at NIS = 4: P shrinks at each innovation within it, and not at one beyond.
TEST(RunInnovations, TellHowPChangesBesideHowFarOutTheNisIs) {
  const RunLayout layout = layout_of({"a"});
  RunInnovations run;
  for (int k = 0; k < 100; ++k) {
    const bool beyond = k % 10 == 9;
    run.begin_step();
    run.add(layout.sensors[0], scalar(beyond ? 3.0 : 1.0), beyond ? 0.0 : -0.5, 0.0);
  }
  Evidence sums;
  add_innovations_of_run({&run, 1}, layout, sums);
  const SensorSums& of_sensor = sums.sensor(layout.sensors[0]);
  EXPECT_EQ(of_sensor.largest_nis, 9.0);
  std::int64_t within = 0, beyond = 0;
  for (const Moments& bin : of_sensor.changes.bins) {
    if (bin.count == 0) continue;
    if (bin.mean == 0.0) beyond += bin.count;
    if (bin.mean == -0.5) within += bin.count;
  }
  EXPECT_EQ(within, 72) << "of the last four fifths";
  EXPECT_EQ(beyond, 8);
}

TEST(RunInnovations, TwoSensorsAreTakenTogetherWhereBothSpeak) {
  const RunLayout layout = layout_of({"a", "b"});
  const RunInnovations runs[] = {in_turn(layout.sensors[0], 12, 2), in_turn(layout.sensors[1], 12, 3)};
  Evidence sums;
  add_innovations_of_run(runs, layout, sums);
  ASSERT_EQ(sums.sensor_pairs.size(), 1U);
  EXPECT_EQ(sums.sensor_pairs.front().both.count, 2) << "at steps 0 and 6";
  EXPECT_EQ(sums.sensor_pairs.front().both.mean[0], 0.0);
}

TEST(RunInnovations, OfNisAloneTheLawIsAllThereIs) {
  RunLayout layout = layout_of({"a"});
  layout.sensors[0].nis_alone = true;
  RunInnovations run;
  for (int k = 0; k < 10; ++k) {
    run.begin_step();
    NormalisedInnovation innovation;
    innovation.value = chi_square_quantile(0.5, 3.0);
    innovation.dof = 3;
    run.add(layout.sensors[0], innovation, kNaN, kNaN);
  }
  EXPECT_NEAR(run.at(0)[0], 0.0, 1e-12) << "the median";
  Evidence sums;
  add_innovations_of_run({&run, 1}, layout, sums);
  EXPECT_TRUE(sums.sensor(layout.sensors[0]).varies);
  EXPECT_EQ(sums.sensor(layout.sensors[0]).ties.inside, 10) << "all are equal";
}

}  // namespace
}  // namespace credence::internal
