#include "datasets/logs/autopilot/ulog_states.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>
#include <string>

#include "datasets/data_error.h"
#include "datasets/logs/autopilot/ulog_innovations.h"
#include "tests/datasets/data_folder.h"
#include "tests/datasets/logs/autopilot/ulog_writer.h"
#include "tests/datasets/logs/byte_writer.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using testing::ByteWriter;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RecordedSink;
using testing::UlogWriter;

RecordedSink read_states(const std::string& bytes, const LogReadOptions& options) {
  const TemporaryFolder folder;
  RecordedSink sink;
  ulog_format().read(folder.write("flight.ulg", bytes), {options, {}, {}}, sink);
  return sink;
}

LogReadOptions against_truth() {
  LogReadOptions options;
  options.truth_topic = std::string(kUlogTruth);
  return options;
}

/// How many states and variances a version of PX4 logs.
struct Counts {
  int states = 24, variances = 24;
};

/// A simulated flight: 30 rows of states at 100 Hz and a truth at 50 Hz, whose origin is elsewhere; one row
/// is not finite. bend: of the truth's way to the north, k + bend k².
UlogWriter simulated(Counts counts, int not_finite = -1, double latitude = 47.0,
                     float estimated_height = 410.0F, float bend = 0.0F) {
  UlogWriter log;
  log.format(fmt::format("estimator_states:uint64_t timestamp;float[{}] states;float[{}] covariances;",
                         counts.states, counts.variances));
  const std::string local =
      "uint64_t timestamp;double ref_lat;double ref_lon;float ref_alt;float x;float y;"
      "float z;float vx;float vy;float vz;";
  log.format("vehicle_local_position:" + local);
  log.format("vehicle_local_position_groundtruth:" + local);
  log.subscribe(1, 0, "estimator_states");
  log.subscribe(2, 0, "vehicle_local_position");
  log.subscribe(3, 0, "vehicle_local_position_groundtruth");
  const auto position = [&](std::uint16_t id, int i, float height) {
    const auto k = static_cast<float>(i);
    ByteWriter row;
    row.add(static_cast<std::uint64_t>(1'000'000 + 10'000 * i)).add(latitude).add(8.5).add(height);
    log.data(id, row.add(k + bend * k * k).add(2.0F * k).add(-k).add(1.0F).add(2.0F).add(-1.0F).bytes());
  };
  for (int i = 0; i < 30; ++i) {
    if (i % 2 == 0) position(3, i, 400.0F);
    position(2, i, estimated_height);
    ByteWriter row;
    row.add(static_cast<std::uint64_t>(1'000'000 + 10'000 * i));
    const auto k = static_cast<float>(i);
    const float north = i == not_finite ? std::numeric_limits<float>::quiet_NaN() : k;
    const float motion[] = {1.5F, 2.0F, -1.0F, north, 2.0F * k, -k + 10.25F};
    for (int s = 0; s < counts.states; ++s) row.add(s >= 4 && s < 10 ? motion[s - 4] : 0.0F);
    // Each is the number of its state; the error state has one component less, of the attitude.
    const int before = counts.states - counts.variances;
    for (int s = 0; s < counts.variances; ++s) row.add(static_cast<float>(s + before));
    log.data(1, row.bytes());
  }
  return log;
}

TEST(UlogStates, StatesOfASimulatedFlightAreJudgedAgainstItsTruth) {
  LogReadOptions options;
  options.truth_topic = "vehicle_local_position_groundtruth";
  // Up to 1.14; an error state since; and with the height of the terrain, from 1.15 on.
  for (const Counts counts : {Counts{24, 24}, Counts{24, 23}, Counts{25, 24}}) {
    const RecordedSink sink = read_states(simulated(counts).bytes(), options);
    ASSERT_EQ(sink.runs.size(), 1U);
    EXPECT_EQ(sink.runs[0].layout.states.size(), 6U);
    EXPECT_EQ(sink.runs[0].layout.units, (std::vector<std::string>{"m/s", "m/s", "m/s", "m", "m", "m"}));
    EXPECT_FALSE(sink.runs[0].layout.joint_covariance);
    ASSERT_EQ(sink.runs[0].steps.size(), 29U);  // the last has no truth behind it
    EXPECT_EQ(sink.unmatched_rows, 1);
    const Step& step = sink.runs[0].steps[7];
    Vector error(6);
    error << 0.5, 0.0, 0.0, 0.0, 0.0, 0.25;
    EXPECT_LT((step.error - error).norm(), 1e-5);  // float, and the earth's curve
    EXPECT_EQ(step.P.diagonal(), (Vector(6) << 4, 5, 6, 7, 8, 9).finished());
  }
  const RecordedSink broken = read_states(simulated({}, 7).bytes(), options);
  EXPECT_EQ(broken.runs.at(0).steps.size(), 28U);
  EXPECT_EQ(broken.unmatched_rows, 1) << "it has a truth";
  EXPECT_THAT(broken.said(), HasSubstr("1 of 30 rows of estimator_states, whose estimate or variance"));
  options.truth_topic = "/gt";
  EXPECT_THAT([&] { read_states(simulated({}).bytes(), options); },
              ::testing::ThrowsMessage<std::invalid_argument>(
                  HasSubstr("accepted is vehicle_local_position_groundtruth")));
}

TEST(UlogStates, WhatLiesBetweenTwoRowsOfTheTruthIsLeftOutWhereItMatters) {
  const auto bent_by = [](float bend) {
    return read_states(simulated({}, -1, 47.0, 410.0F, bend).bytes(), against_truth());
  };
  EXPECT_EQ(bent_by(0.5F).runs.at(0).steps.size(), 29U);
  const RecordedSink bent = bent_by(2.0F);
  EXPECT_EQ(bent.runs.at(0).steps.size(), 15U);
  EXPECT_EQ(bent.unmatched_rows, 15);
  EXPECT_THAT(bent.said(), HasSubstr("14 rows are left out, whose truth lies between two of its rows"));
}

// Without an origin a local position is of an unknown place; a height of exactly 0 is one that nobody set.
TEST(UlogStates, WhatHasNoOriginIsNotJudgedAndSaysSo) {
  const RecordedSink nowhere = read_states(simulated({24, 23}, -1, std::nan("")).bytes(), against_truth());
  ASSERT_EQ(nowhere.runs.size(), 1U);
  EXPECT_EQ(nowhere.runs[0].layout.states,
            (std::vector<std::string>{"velocity.north", "velocity.east", "velocity.down"}));
  EXPECT_EQ(nowhere.runs[0].layout.units, std::vector<std::string>(3, "m/s"));
  EXPECT_EQ(nowhere.runs[0].steps.at(3).P.diagonal(), Vector(Eigen::Vector3d(4, 5, 6)));
  EXPECT_LT((nowhere.runs[0].steps[3].error - Eigen::Vector3d(0.5, 0.0, 0.0)).norm(), 1e-6);
  EXPECT_THAT(nowhere.said(), HasSubstr("Positions are not judged: the log does not hold the origins"));
  const RecordedSink flat = read_states(simulated({24, 23}, -1, 47.0, 0.0F).bytes(), against_truth());
  EXPECT_EQ(flat.runs.at(0).layout.states.size(), 5U);
  EXPECT_EQ(flat.runs[0].layout.states.back(), "position.east");
  EXPECT_THAT(flat.said(), HasSubstr("Heights are not judged"));
  const RecordedSink whole = read_states(simulated({24, 23}).bytes(), against_truth());
  EXPECT_THAT(whole.said(), Not(HasSubstr("not judged")));
}

// A position that is not finite says nothing against the velocity beside it.
TEST(UlogStates, WhatIsNotJudgedNeedNotBeFinite) {
  const RecordedSink nowhere = read_states(simulated({24, 23}, 7, std::nan("")).bytes(), against_truth());
  ASSERT_EQ(nowhere.runs.at(0).steps.size(), 29U);
  EXPECT_LT((nowhere.runs[0].steps[7].error - Eigen::Vector3d(0.5, 0.0, 0.0)).norm(), 1e-6);
  EXPECT_THAT(nowhere.said(), Not(HasSubstr("not finite")));
}

TEST(UlogStates, AnInstanceThatIsNotThereIsRefusedNamingThoseThatAre) {
  LogReadOptions options = against_truth();
  options.instance = 3;
  EXPECT_THAT(
      [&] {
        read_states(simulated({24, 23}).bytes(), options);
      },
      ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("--instance 3: there are 0")));
  options.instance = 0;
  EXPECT_EQ(read_states(simulated({24, 23}).bytes(), options).runs.size(), 1U);
}

TEST(UlogStates, ALogWithoutStatesOrTruthOrACommonTimeIsRefused) {
  const auto refused = [](const std::string& bytes, const LogReadOptions& options,
                          const std::string& message) {
    EXPECT_THAT([&] { read_states(bytes, options); },
                ::testing::ThrowsMessage<DataError>(HasSubstr(message)));
  };
  UlogWriter without;
  without.format(
      "vehicle_local_position_groundtruth:uint64_t timestamp;float x;float y;float z;float vx;float vy;float "
      "vz;");
  without.subscribe(3, 0, "vehicle_local_position_groundtruth");
  ByteWriter row;
  row.add(std::uint64_t{1'000'000});
  for (int i = 0; i < 6; ++i) row.add(0.0F);
  without.data(3, row.bytes());
  refused(without.bytes(), against_truth(), "holds no estimator_states");
  UlogWriter untrue;
  untrue.format("estimator_states:uint64_t timestamp;float[24] states;float[23] covariances;");
  untrue.subscribe(1, 0, "estimator_states");
  ByteWriter states;
  states.add(std::uint64_t{50'000'000});
  for (int i = 0; i < 47; ++i) states.add(1.0F);
  untrue.data(1, states.bytes());
  refused(untrue.bytes(), against_truth(), "it holds no messages");
}

}  // namespace
}  // namespace credence::internal
