#include "datasets/logs/autopilot/innovation_series.h"

#include <gmock/gmock.h>

#include <limits>

#include "core/nan.h"
#include "datasets/data_error.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using testing::RecordedSink;
using Row = InnovationSeries::Row;

Row add_scalar(InnovationSeries& series, std::size_t sensor, double time_s, double nu,
               double variance = 1.0) {
  return series.add(sensor, time_s, {&nu, 1}, {&variance, 1});
}

TEST(InnovationSeries, the_kth_innovations_of_all_sensors_stand_in_step_k) {
  InnovationSeries series;
  const std::size_t fast = series.sensor("heading", 1, true), slow = series.sensor("gps", 2, false);
  series.sensor("flow", 2, false);
  EXPECT_EQ(series.sensor("gps", 2, false), slow) << "a name is of one sensor";
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(add_scalar(series, fast, 0.1 * i, i, 2.0 + i), Row::taken);
    if (i % 2 == 1) continue;
    const double nu[] = {10.0 + i, 20.0 + i}, variances[] = {0.5, 0.25};
    EXPECT_EQ(series.add(slow, 0.1 * i, nu, variances), Row::taken);
  }
  RecordedSink sink;
  series.emit(sink);
  ASSERT_EQ(sink.runs.size(), 1U);
  const RecordedSink::Run& run = sink.runs[0];
  EXPECT_FALSE(run.layout.has_truth);
  EXPECT_EQ(run.layout.sensors,
            (std::vector<Sensor>{{.name = "heading", .dim = 1, .piece = 1, .angles = {true}},
                                 {.name = "gps", .dim = 2, .piece = 2, .variances_alone = true}}));
  ASSERT_EQ(run.steps.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    const Step& step = run.steps[static_cast<std::size_t>(i)];
    EXPECT_EQ(step.step, i + 1);
    EXPECT_EQ(step.innovations.at(0).nu, Vector::Constant(1, i));
    EXPECT_EQ(step.innovations[0].S, Matrix::Constant(1, 1, 2.0 + i));
    ASSERT_EQ(step.innovations.at(1).nu.size(), i < 2 ? 2 : 0);
  }
  EXPECT_EQ(run.steps[1].innovations[1].nu, Eigen::Vector2d(12, 22));
  EXPECT_EQ(run.steps[1].innovations[1].S, (Matrix(2, 2) << 0.5, 0, 0, 0.25).finished());
  EXPECT_TRUE(series.any_vector());
  EXPECT_EQ(series.counts(), "4 of heading (10 Hz), 2 of gps (5 Hz)");
}

TEST(InnovationSeries, a_value_said_again_is_no_new_innovation) {
  InnovationSeries series;
  const std::size_t s = series.sensor("baro", 1, false);
  EXPECT_EQ(add_scalar(series, s, 0.0, 1.0), Row::taken);
  EXPECT_EQ(add_scalar(series, s, 1.0, 1.0, 9.0), Row::repeated);
  EXPECT_EQ(add_scalar(series, s, 2.0, 2.0), Row::taken);
  EXPECT_EQ(add_scalar(series, s, 3.0, 1.0), Row::taken) << "it is the row before that counts";
  const double nu = 5.0, variance = 1.0, first[] = {1.0, 7.0}, second[] = {1.0, 8.0};
  EXPECT_EQ(series.add(s, 4.0, {&nu, 1}, {&variance, 1}, first), Row::taken);
  EXPECT_EQ(series.add(s, 5.0, {&nu, 1}, {&variance, 1}, second), Row::taken) << "by what the log says";
  EXPECT_EQ(series.add(s, 6.0, {&nu, 1}, {&variance, 1}, second), Row::repeated);
}

TEST(InnovationSeries, without_a_variance_a_sensor_is_silent) {
  InnovationSeries series;
  const std::size_t s = series.sensor("baro", 1, false);
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double variance : {0.0, -1.0, kNaN, infinity})
    EXPECT_EQ(add_scalar(series, s, 0.0, 1.0, variance), Row::silent) << variance;
  for (const double nu : {kNaN, infinity, -infinity})
    EXPECT_EQ(add_scalar(series, s, 0.0, nu), Row::silent) << nu;
  EXPECT_TRUE(series.empty());
  EXPECT_EQ(series.counts(), "");
  EXPECT_FALSE(series.any_vector());
}

TEST(InnovationSeries, one_value_that_is_repeated_for_ever_is_no_sensor) {
  InnovationSeries series;
  const std::size_t s = series.sensor("gps", 1, false);
  add_scalar(series, s, 0.0, 0.0);
  EXPECT_FALSE(series.empty()) << "a value may be the only one";
  add_scalar(series, s, 1.0, 0.0);
  EXPECT_TRUE(series.empty());
  add_scalar(series, s, 2.0, 3.0);
  EXPECT_FALSE(series.empty());
}

TEST(InnovationSeries, nis_alone_is_handed_on_as_it_is) {
  InnovationSeries series;
  const std::size_t s = series.nis_sensor("mag");
  EXPECT_EQ(series.add_nis(s, 0.0, 2.25), Row::taken);
  EXPECT_EQ(series.add_nis(s, 0.0, 2.25), Row::repeated);
  for (const double nis : {0.0, -1.0, kNaN, std::numeric_limits<double>::infinity()})
    EXPECT_EQ(series.add_nis(s, 0.0, nis), Row::silent) << nis;
  EXPECT_EQ(series.add_nis(s, 1.0, 4.0), Row::taken);
  RecordedSink sink;
  series.emit(sink);
  EXPECT_EQ(sink.runs.at(0).layout.sensors,
            (std::vector<Sensor>{{.name = "mag", .dim = 1, .piece = 1, .nis_alone = true}}));
  EXPECT_EQ(sink.runs[0].steps.at(0).innovations.at(0).nu[0], 2.25);
  EXPECT_EQ(sink.runs[0].steps.at(1).innovations.at(0).S.size(), 0);
}

TEST(InnovationSeries, sensors_that_never_repeat_are_named_from_twenty_rows_on) {
  InnovationSeries series;
  const std::size_t few = series.sensor("few", 1, false), many = series.sensor("many", 2, false),
                    once = series.sensor("once", 1, false);
  for (int i = 0; i < 20; ++i) {
    const double nu[] = {1.0 * i, 0.0}, variances[] = {1.0, 1.0};
    series.add(many, i, nu, variances);
    add_scalar(series, once, i, i);
    if (i > 0) add_scalar(series, few, i, i);
  }
  add_scalar(series, once, 20.0, 19.0);
  EXPECT_EQ(series.never_repeated(), "many");
}

TEST(InnovationSeries, the_number_of_an_estimator_is_a_whole_one_up_to_255) {
  const ByteOrigin origin{"flight.ulg", ""};
  const ByteCursor message({}, origin, 123);
  EXPECT_EQ(estimator_number(0.0, message), 0);
  EXPECT_EQ(estimator_number(255.0, message), 255);
  for (const double said : {-1.0, 0.5, 256.0, 1e300, kNaN}) {
    EXPECT_THAT(
        [&] { estimator_number(said, message); },
        ::testing::ThrowsMessage<DataError>(HasSubstr("flight.ulg:byte 123: an estimator of number")));
  }
}

}  // namespace
}  // namespace credence::internal
