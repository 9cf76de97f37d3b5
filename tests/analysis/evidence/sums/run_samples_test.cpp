#include "analysis/evidence/sums/run_samples.h"

#include <gtest/gtest.h>

#include <cmath>

namespace credence::internal {
namespace {

Vector both(double a, double b) { return Vector{{a, b}}; }

TEST(RunSamples, AreErrorsOverTheirStandardDeviations) {
  RunSamples samples;
  EXPECT_EQ(samples.count(), 0);
  EXPECT_EQ(samples.errors().cols(), 0);
  samples.add(both(3.0, -1.0), both(9.0, 0.25));
  ASSERT_EQ(samples.count(), 1);
  EXPECT_EQ(samples.errors().col(0), both(1.0, -2.0));
  EXPECT_DOUBLE_EQ(samples.log_variances()[0], 0.5 * std::log(9.0 * 0.25));
}

// Of 12,000 rows every eighth: 1,500, and of 3,000 at most 512 every eighth.
TEST(RunSamples, OfALongRunLieEvenlyOverIt) {
  RunSamples samples;
  for (int k = 0; k < 12000; ++k) {
    samples.add(both(k, 1.0), both(1.0, std::exp(2.0 * k / 12000.0)));
    if (k + 1 != 3000) continue;
    ASSERT_EQ(samples.count(), 1500);
    const Matrix some = samples.errors(512);
    ASSERT_EQ(some.cols(), 375);
    for (Index i = 0; i < some.cols(); ++i) EXPECT_EQ(some(0, i), 8.0 * static_cast<double>(i));
  }
  ASSERT_EQ(samples.count(), 1500);
  for (Index i = 0; i < samples.count(); ++i) {
    EXPECT_EQ(samples.errors()(0, i), 8.0 * static_cast<double>(i));
    EXPECT_NEAR(samples.log_variances()[i], 8.0 * static_cast<double>(i) / 12000.0, 1e-12);
  }
}

TEST(RunSamples, LeaveOutWhatIsNotOfTheirStates) {
  RunSamples samples;
  samples.add(both(1.0, 1.0), both(1.0, 1.0));
  samples.add(Vector::Ones(3), Vector::Ones(3));
  samples.add(both(1.0, 0.0), both(1.0, 0.0));  // known for certain
  EXPECT_EQ(samples.count(), 1);
  RunSamples large;
  large.add(Vector::Ones(RunSamples::kLargest + 1), Vector::Ones(RunSamples::kLargest + 1));
  EXPECT_EQ(large.count(), 0);
}

}  // namespace
}  // namespace credence::internal
