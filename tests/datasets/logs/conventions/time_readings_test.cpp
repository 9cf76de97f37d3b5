#include "datasets/logs/conventions/time_readings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace credence::internal {
namespace {

constexpr double kSpacing_s = 0.25;
constexpr int kSamples = 400;

/// At (4 t, 3 sin t, 0) m, from 0 s until the last estimate.
bool truth_at(double t, SpatialPose& truth) {
  truth = {Eigen::Vector3d(4.0 * t, 3.0 * std::sin(t), 0.0)};
  return t >= 0.0 && t <= kSpacing_s * (kSamples - 1);
}

/// Estimates that are right but for 1 mm, whose times are so much too late.
std::vector<PoseSample> late_by(double late_s) {
  std::vector<PoseSample> samples;
  for (int i = 0; i < kSamples; ++i) {
    PoseSample sample{.time_s = kSpacing_s * i};
    truth_at(sample.time_s, sample.truth);
    truth_at(sample.time_s - late_s, sample.estimate);
    sample.estimate.position.z() += i % 2 == 0 ? 1e-3 : -1e-3;
    sample.written = 1e-6 * PoseCovariance::Identity();
    samples.push_back(sample);
  }
  return samples;
}

std::vector<TimeReading> readings_of(const std::vector<PoseSample>& samples) {
  return time_readings(pose_chart_named("ros"), samples, kSpacing_s, truth_at);
}

const TimeReading* named(const std::vector<TimeReading>& readings, std::string_view words) {
  const auto found = std::ranges::find_if(readings, [&](const TimeReading& reading) {
    return reading.reading.cause.find(words) != std::string::npos;
  });
  return found == readings.end() ? nullptr : &*found;
}

TEST(TimeReadings, OneSampleIsTriedBothWaysWhereThereIsATruth) {
  const std::vector<TimeReading> readings = readings_of(late_by(0.0));
  ASSERT_EQ(readings.size(), 2U) << "the times are right: none fits better";
  const TimeReading& early = readings[0];
  EXPECT_EQ(early.reading.cause, "the estimate's times are 0.25 s, one sample, too early");
  ASSERT_EQ(early.samples.size(), static_cast<std::size_t>(kSamples - 1))
      << "the last has no truth behind it";
  EXPECT_EQ(early.samples[2].truth.position.x(), 4.0 * 3.0 * kSpacing_s);
  const TimeReading& late = readings[1];
  EXPECT_EQ(late.reading.cause, "the estimate's times are 0.25 s, one sample, too late");
  EXPECT_EQ(late.reading.repair, "the time of what was estimated, or --time-offset -0.25");
  EXPECT_EQ(late.samples[0].truth.position.x(), 0.0);
  EXPECT_EQ(late.samples[0].time_s, kSpacing_s);
}

TEST(TimeReadings, AnyTimeWithinASecondIsFound) {
  for (const double late_s : {0.11, -0.07, 0.73}) {
    const std::vector<TimeReading> readings = readings_of(late_by(late_s));
    ASSERT_EQ(readings.size(), 3U) << late_s;
    const PoseSample& sample = readings[2].samples[100];
    EXPECT_NEAR(sample.truth.position.x(), 4.0 * (sample.time_s - late_s), 1e-4) << late_s;
    EXPECT_NE(readings[2].reading.cause.find(late_s > 0.0 ? "too late" : "too early"), std::string::npos);
  }
  EXPECT_EQ(readings_of(late_by(0.11))[2].reading.repair,
            "the time of what was estimated, or --time-offset -0.11; --time-offset estimate finds it");
  EXPECT_EQ(readings_of(late_by(kSpacing_s)).size(), 2U) << "told as one sample";
}

TEST(TimeReadings, TimesAtWhichFewSamplesHaveATruthAreNotTried) {
  std::vector<PoseSample> samples = late_by(0.0);
  samples.erase(samples.begin(), samples.end() - 1);
  EXPECT_EQ(named(readings_of(samples), "too early"), nullptr);
  EXPECT_NE(named(readings_of(samples), "too late"), nullptr);
}

}  // namespace
}  // namespace credence::internal
