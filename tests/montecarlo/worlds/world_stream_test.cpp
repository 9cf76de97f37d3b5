#include "montecarlo/worlds/world_stream.h"

#include <gtest/gtest.h>

#include <string>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

// The columns are of the world, not of a run: the first one may measure nothing, and a later one does.
TEST(WorldStream, ARunThatMeasuresNothingIsLegal) {
  const std::string missed = "[noise]\ndetection_probability = 0.02\n[study]\nruns = 300\nsteps = 4\n";
  struct Case {
    std::string world;
    Index numbers;
  };
  for (const Case& c :
       {Case{"model = \"pendulum\"\n", 1}, Case{"model = \"tracking\"\nsensor = \"range_bearing\"\n", 2},
        Case{"model = \"tracking\"\n", 2}}) {
    const WorldStream stream = world_stream(load_scenario_text("[world]\n" + c.world + missed, "test"));
    EXPECT_EQ(std::ssize(stream.measurements), c.numbers) << c.world;
    int silent = 0, measured = 0;
    for (std::int64_t run = 0; run < 300; ++run) {
      bool any = false;
      stream.visit(run, [&](std::int64_t, const StreamRow& row) {
        if (row.measurement.size() > 0) {
          EXPECT_EQ(row.measurement.size(), c.numbers) << c.world;
        }
        any = any || (row.measurement.array() == row.measurement.array()).any();
      });
      ++(any ? measured : silent);
    }
    EXPECT_GT(silent, 0) << c.world;
    EXPECT_GT(measured, 0) << c.world;
  }
}

}  // namespace
}  // namespace credence::internal
