#include "montecarlo/worlds/world_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/planar_slam/odometry_world.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

// A filter that is fed from the rows alone has the bits of the filter in the scenario's experiment.
TEST(OdometryStream, AFilterThatReadsItIsThatOfTheExperiment) {
  for (const char* sensor : {"relative_position", "range_bearing"}) {
    for (const char* noise : {"noise.detection_probability=1", "noise.detection_probability=0.6",
                              "noise.measurement_delay=1", "noise.student_dof=4"}) {
      const Scenario scenario = load_scenario_text(
          "[world]\nmodel = \"planar_slam\"\n", "t.toml",
          std::vector<std::string>{std::string("world.landmark_sensor=") + sensor, noise, "study.steps=20",
                                   "filter.measurement_scale=2", "filter.estimator=ekf"});
      std::vector<StreamRow> rows;
      world_stream(scenario).visit(4, [&](std::int64_t step, const StreamRow& row) {
        EXPECT_EQ(step, std::ssize(rows));
        rows.push_back(row);
      });
      const RunTrace trace = make_experiment(scenario)->trace(4);
      ASSERT_EQ(rows.size(), 21U);
      const OdometryWorld world = make_odometry_world(scenario);
      const auto filter = scenario_estimator(scenario, world);
      filter->reset(Pose(rows[0].prior), world.noise.initial_covariance());
      for (std::size_t k = 1; k < rows.size(); ++k) {
        EXPECT_EQ(rows[k].truth, Vector(trace.steps[k].truth.head(3)));
        std::vector<Observation<PlanarModel>> seen;
        for (Index i = 0; i < rows[k].measurement.size() / 2; ++i) {
          const Eigen::Vector2d z = rows[k].measurement.segment<2>(2 * i);
          if (!std::isnan(z[0])) seen.push_back({static_cast<int>(i), z});
        }
        filter->predict(Control(rows[k].input), world.truth(k));
        filter->update(seen, world.truth(k));
        EXPECT_EQ(Vector(filter->state()), trace.steps[k].estimate) << k << noise;
      }
    }
  }
}

TEST(OdometryStream, NamesWhatItsSensorSays) {
  const auto names = [](const char* sensor) {
    return world_stream(load_scenario_text("[world]\nmodel = \"planar_slam\"\nlandmarks = 1\n", "t.toml",
                                           std::vector<std::string>{sensor}))
        .measurements;
  };
  EXPECT_THAT(names("world.landmark_sensor=relative_position"),
              testing::ElementsAre("landmark1.x", "landmark1.y"));
  EXPECT_THAT(names("world.landmark_sensor=range_bearing"),
              testing::ElementsAre("landmark1.range", "landmark1.bearing"));
}

}  // namespace
}  // namespace credence::internal
