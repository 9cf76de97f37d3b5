#include "datasets/logs/arrays/npz_writer.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "datasets/logs/arrays/npz.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

TEST(NpzWriter, WhatIsWrittenIsReadToTheLastBit) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<NamedArray> arrays = {
      {"error", {1, 2, 2}, {0.1, -1.0 / 3.0, nan, 1e-300}},
      {"P", {1, 2, 2, 2}, {2.0, 0.1, 0.1, 3.0, nan, nan, nan, std::nextafter(1.0, 2.0)}}};
  const TemporaryFolder folder;
  testing::RecordedSink sink;
  npz_format().read(folder.write("a.npz", npz_bytes(arrays)), {}, sink);
  ASSERT_EQ(sink.runs.size(), 1U);
  ASSERT_EQ(sink.runs[0].steps.size(), 2U);
  EXPECT_EQ(sink.runs[0].steps[0].error, Eigen::Vector2d(0.1, -1.0 / 3.0));
  EXPECT_EQ(sink.runs[0].steps[0].P(0, 1), 0.1);
  EXPECT_EQ(sink.runs[0].steps[1].states, std::vector<Index>{1});
  EXPECT_EQ(sink.runs[0].steps[1].error[0], 1e-300);
  EXPECT_EQ(sink.runs[0].steps[1].P(0, 0), std::nextafter(1.0, 2.0));
}

TEST(NpzWriter, TextsAreReadAsTheNamesOfTheStates) {
  const std::vector<NamedArray> arrays = {{"error", {1, 1, 2}, {0.1, 0.2}},
                                          {"P", {1, 1, 2, 2}, {2.0, 0.1, 0.1, 3.0}},
                                          {"names", {2}, {}, {"Höhe.z", "ψ:angle"}}};
  const TemporaryFolder folder;
  testing::RecordedSink sink;
  npz_format().read(folder.write("a.npz", npz_bytes(arrays)), {}, sink);
  ASSERT_EQ(sink.runs.size(), 1U);
  EXPECT_THAT(sink.runs[0].layout.states, ::testing::ElementsAre("Höhe.z", "ψ"));
  EXPECT_THAT(sink.runs[0].layout.angles, ::testing::ElementsAre(false, true));
}

TEST(NpzWriter, ValuesFillTheDimensions) {
  const NamedArray wrong{"error", {2, 2}, {1.0}};
  EXPECT_THAT(
      [&] {
        npz_bytes({&wrong, 1});
      },
      ::testing::ThrowsMessage<std::invalid_argument>(
          ::testing::HasSubstr("error: 1 values for dimensions (2, 2)")));
}

}  // namespace
}  // namespace credence::internal
