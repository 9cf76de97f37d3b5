#include "datasets/logs/autopilot/dataflash.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "datasets/data_error.h"
#include "datasets/logs/autopilot/dataflash_innovations.h"
#include "tests/datasets/logs/autopilot/dataflash_writer.h"
#include "tests/datasets/logs/hostile.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using testing::ByteWriter;
using testing::DataflashWriter;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::padded;
using testing::RecordedSink;
using ::testing::ThrowsMessage;

RecordedSink flight_of(const std::string& bytes, const LogReadOptions& options = {}) {
  const TemporaryFolder folder;
  RecordedSink sink;
  dataflash_format().read(folder.write("flight.bin", bytes), {options, {}, {}}, sink);
  return sink;
}

DataflashWriter short_flight(std::uint8_t core = 0) {
  DataflashWriter log;
  log.parameter("EK3_HGT_I_GATE", 300.0F);
  for (int i = 0; i < 4; ++i) {
    const auto time = static_cast<std::uint64_t>(1'000'000 + 100'000 * i);
    const double k = i / 2 + 1.0;  // every row twice
    log.innovations(time, core, {0.3 * k, -0.4 * k, 0.0, 0.0, 0.0, -0.5 * k, 0.0});
    log.ratios(time, core, {0.1 * k, 0.2, 0.3 * k, 0.0, 0.0});
  }
  return log;
}

TEST(Dataflash, InnovationsAndRootsOfTestRatiosGiveNis) {
  const RecordedSink sink = flight_of(short_flight().bytes());
  ASSERT_EQ(sink.runs.size(), 1U);
  const RecordedSink::Run& run = sink.runs.front();
  EXPECT_FALSE(run.layout.has_truth);
  ASSERT_EQ(run.layout.sensors.size(), 2U);  // position only repeats itself, airspeed says nothing
  EXPECT_EQ(run.layout.sensors[0].name, "velocity");
  EXPECT_EQ(run.layout.sensors[1].name, "height");
  ASSERT_EQ(run.steps.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    const Step& step = run.steps[static_cast<std::size_t>(i)];
    const Vector& velocity = step.innovations[0].nu;
    // m Σν²/ΣS = m ratio gate², with the gate of 5 that ArduPilot has by default.
    EXPECT_NEAR(velocity.squaredNorm(), 3.0 * std::pow(0.1 * (i + 1) * 5.0, 2), 1e-12);
    EXPECT_NEAR(velocity[0] / velocity[1], -0.75, 1e-12);
    EXPECT_EQ(step.innovations[0].S, Matrix::Identity(3, 3));
    EXPECT_NEAR(step.innovations[1].nu[0], -0.3 * (i + 1) * 3.0, 1e-12);  // the gate of the log
  }
  EXPECT_THAT(sink.said(), HasSubstr("4 rows of XKF3 with XKF4"));
  EXPECT_THAT(sink.said(), HasSubstr("steps of 0.01"));
  EXPECT_THAT(sink.said(), HasSubstr("does not hold the gates EK3_VEL_I_GATE 500"));
  EXPECT_THAT(sink.said(), Not(HasSubstr("EK3_HGT_I_GATE")));
  EXPECT_THAT(sink.said(), Not(HasSubstr("clamped")));
}

TEST(Dataflash, AConsistentFilterHasItsMeanNis) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  DataflashWriter log;
  constexpr int kRows = 4000;
  const double sigma = 0.7;  // of every component
  for (int i = 0; i < kRows; ++i) {
    std::array<double, 7> nu{};
    for (double& component : nu) component = sigma * normal(random);
    const auto root = [&](int first, int count) {
      double sum = 0.0;
      for (int c = first; c < first + count; ++c) sum += std::pow(nu[static_cast<std::size_t>(c)], 2);
      return std::sqrt(sum / (count * sigma * sigma)) / 5.0;
    };
    const auto time = static_cast<std::uint64_t>(100'000 * (i + 1));
    log.innovations(time, 0, nu);
    log.ratios(time, 0, {root(0, 3), root(3, 2), root(5, 1), 0.0, root(6, 1) * 5.0 / 4.0});
  }
  const RecordedSink sink = flight_of(log.bytes());
  ASSERT_EQ(sink.runs.front().layout.sensors.size(), 4U);
  const double dims[] = {3.0, 2.0, 1.0, 1.0};
  for (std::size_t s = 0; s < 4; ++s) {
    double sum = 0.0, count = 0.0;
    for (const Step& step : sink.runs.front().steps) {
      const Innovation& innovation = step.innovations[s];
      if (innovation.nu.size() == 0) continue;
      EXPECT_EQ(innovation.nu.size(), static_cast<Index>(dims[s]));
      sum += innovation.nu.squaredNorm();
      ++count;
    }
    EXPECT_GT(count, 0.95 * kRows);  // few are equal to the one before by chance
    // Mean of χ²(m) over `count`: five standard errors; the steps of 0.01 add 0.05²/12 to a variance of 1.
    EXPECT_NEAR(sum / count, dims[s], 5.0 * std::sqrt(2.0 * dims[s] / count) + 0.001) << s;
  }
}

TEST(Dataflash, AClampedRatioIsTold) {
  DataflashWriter log = short_flight();
  log.innovations(9'000'000, 0, {0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0});
  log.ratios(9'000'000, 0, {0.0, 0.0, 327.67, 0.0, 0.0});
  EXPECT_THAT(flight_of(log.bytes()).said(), HasSubstr("1 test ratio is clamped"));
}

TEST(Dataflash, OneOfSeveralCoresIsJudged) {
  DataflashWriter log = short_flight();
  for (int i = 0; i < 2; ++i) {
    const auto time = static_cast<std::uint64_t>(5'000'000 + i);
    log.innovations(time, 1, {0.0, 0.0, 0.0, 0.0, 0.0, 1.0 + i, 0.0});
    log.ratios(time, 1, {0.0, 0.0, 0.5 + i, 0.0, 0.0});
  }
  EXPECT_THAT(flight_of(log.bytes()).said(), HasSubstr("Cores 0, 1 ran side by side; judged is 0"));
  EXPECT_NEAR(flight_of(log.bytes(), {.instance = 1}).runs[0].steps[0].innovations[0].nu[0], 1.5, 1e-12);
  EXPECT_THAT([&] { flight_of(log.bytes(), {.instance = 4}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("--instance 4: there are 0, 1")));
}

TEST(Dataflash, FieldsOfEveryLetterAreNumbers) {
  DataflashWriter log;
  log.describe(9, 3 + 1 + 2 + 4 + 4 + 8 + 2 + 64, "ALL", "bCeLdgZ", "A,B,D,E,F,G,T");
  log.message(9, ByteWriter()
                     .add<std::int8_t>(-3)
                     .add<std::uint16_t>(250)
                     .add<std::int32_t>(-150)
                     .add<std::int32_t>(473'000'000)
                     .add(0.125)
                     .add<std::uint16_t>(0xc100)  // −2.5
                     .text(padded("words", 64))
                     .bytes());
  const TemporaryFolder folder;
  DataflashTopic all;
  std::vector<double> numbers;
  std::string text;
  read_dataflash(folder.write("a.bin", log.bytes()),
                 {.topic = [&](std::uint8_t, const DataflashTopic& topic) { all = topic; },
                  .message =
                      [&](std::uint8_t type, const ByteCursor& body) {
                        if (type != 9) return;
                        for (const DataflashTopic::Field& field : all.fields) {
                          if (field.type != 'Z') numbers.push_back(dataflash_number(body, field));
                        }
                        text = dataflash_text(body, *all.field("T"));
                        EXPECT_THROW(dataflash_number(body, *all.field("T")), DataError);
                      }});
  EXPECT_EQ(numbers, (std::vector<double>{-3.0, 2.5, -1.5, 473'000'000 * 1e-7, 0.125, -2.5}));
  EXPECT_EQ(text, "words");
}

TEST(Dataflash, AnErrorNamesTheByteAndAPartCanBeRead) {
  const std::string good = short_flight().bytes();
  const auto fails_with = [](const std::string& bytes, const std::string& message) {
    EXPECT_THAT([&] { flight_of(bytes); }, ThrowsMessage<DataError>(HasSubstr(message)));
  };
  fails_with("", "byte 0: is empty");
  fails_with(good + "xyz", "byte " + std::to_string(good.size()) + ": no message begins here");
  fails_with(good + "\xa3\x95\x07", "a message of type 7 that no FMT describes");
  fails_with(good.substr(0, good.size() - 1), "XKF4 of 19 bytes begins here and the file ends at byte");
  fails_with(DataflashWriter().bytes(), "holds no innovations with test ratios");
  DataflashWriter odd;
  odd.describe(9, 5, "ODD", "bb?", "A,B,C");
  fails_with(odd.bytes(), "ODD: a field of type 0x3f that is not known");
  DataflashWriter shorter;
  shorter.describe(9, 7, "LEN", "bb", "A,B");
  fails_with(shorter.bytes(), "LEN: fields of 5 bytes in messages of 7");
  DataflashWriter huge;
  huge.describe(4, 3 + 16, "XKF3", "QQ", "TimeUS,C");
  huge.message(4, ByteWriter().add<std::uint64_t>(1).add(std::uint64_t{1} << 60U).bytes());
  fails_with(huge.bytes(), "an estimator of number 1.152921504606847e+18: corrupted");
  const RecordedSink part = flight_of(good + "xyz", {.partial = true});
  EXPECT_EQ(part.runs.front().steps.size(), 2U);
  EXPECT_THAT(part.said(), HasSubstr("only a part could be read: "));
}

TEST(Dataflash, ListNamesWhatCanBeJudged) {
  const TemporaryFolder folder;
  const LogContents contents = dataflash_format().list(folder.write("a.bin", short_flight().bytes()));
  const auto found = std::ranges::find(contents.topics, "XKF4", &LogTopic::name);
  ASSERT_NE(found, contents.topics.end());
  EXPECT_EQ(found->count, 4);
  EXPECT_NEAR(found->rate_hz, 10.0, 1e-9);
  EXPECT_EQ(found->use, "innovations");
}

TEST(Dataflash, NoCutOrFlippedByteCrashes) {
  // A cut between two messages leaves a whole log: at most one for each message.
  EXPECT_LE(testing::unnoticed_cuts(dataflash_format(), short_flight().bytes(), {}), 14U);
}

}  // namespace
}  // namespace credence::internal
