#include "analysis/evidence/consistency_gated.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace credence::internal {
namespace {

/// Of χ²(2) cut at the gate g: 2 − g/(e^{g/2} − 1).
double truncated_mean(double gate) { return 2.0 - gate / std::expm1(0.5 * gate); }

TEST(GatedNis, IsExpectedToBeTheMeanOfTheTruncatedLaw) {
  const std::vector<Moments> steps(3, Moments{.count = 50, .mean = 1.5});
  for (const double gate : {0.5, 5.991, 9.21}) {
    const ConsistencyVerdict verdict = judge_gated_nis(steps, 2.0, gate, 0.95);
    EXPECT_NEAR(verdict.expected, truncated_mean(gate), 1e-9) << gate;
    ASSERT_EQ(verdict.steps.size(), 3U);
    for (const StepTest& step : verdict.steps) EXPECT_NEAR(step.expected, truncated_mean(gate), 1e-9);
    EXPECT_EQ(verdict.count, 150);
  }
}

TEST(GatedNis, WithAWideGateIsThatOfNis) {
  const std::vector<Moments> steps{{.count = 100, .mean = 2.3}, {}, {.count = 80, .mean = 1.8}};
  const ConsistencyVerdict gated = judge_gated_nis(steps, 2.0, 300.0, 0.95);
  const ConsistencyVerdict plain = judge_nis(steps, std::vector{200.0, 0.0, 160.0}, 0.95);
  EXPECT_NEAR(gated.expected, plain.expected, 1e-9);
  // χ² has the three cumulants that are matched, so that the laws are the same.
  EXPECT_NEAR(gated.overall_p_value, plain.overall_p_value, 1e-6);
  EXPECT_NEAR(gated.steps_p_value, plain.steps_p_value, 1e-6);
  EXPECT_EQ(gated.steps_tested, 2);
  EXPECT_EQ(gated.steps_without_data, 1);
}

TEST(GatedNis, OfANarrowGateIsThatOfUniformValues) {
  // Far inside its gate the density of χ²(2) is flat: mean g/2 and variance g²/12 of one value.
  constexpr double kGate = 1e-3;
  constexpr std::int64_t kCount = 400;
  const auto p_value = [](double errors) {
    const double mean = kGate * (0.5 + errors / std::sqrt(12.0 * static_cast<double>(kCount)));
    const std::vector<Moments> step{{.count = kCount, .mean = mean}};
    return judge_gated_nis(step, 2.0, kGate, 0.95).p_value;
  };
  for (const double errors : {-2.5, -1.0, 1.0, 2.5}) {
    EXPECT_NEAR(p_value(errors), std::erfc(std::abs(errors) / std::sqrt(2.0)), 2e-3) << errors;
  }
}

TEST(GatedNis, RefusesWhatIsNoGate) {
  const std::vector<Moments> steps(3, Moments{.count = 50, .mean = 1.5});
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW(judge_gated_nis(steps, 2.0, bad, 0.95), std::invalid_argument) << bad;
    EXPECT_THROW(judge_gated_nis(steps, bad, 9.21, 0.95), std::invalid_argument) << bad;
  }
  EXPECT_THROW(judge_gated_nis(steps, 2.0, 9.21, 1.0), std::invalid_argument);
  const std::vector<Moments> negative{{.count = -1, .mean = 1.0}};
  EXPECT_THROW(judge_gated_nis(negative, 2.0, 9.21, 0.95), std::invalid_argument);
  const std::vector<Moments> unknown{{.count = 5, .mean = std::nan("")}};
  EXPECT_EQ(judge_gated_nis(unknown, 2.0, 9.21, 0.95).verdict, Verdict::undecided);
}

}  // namespace
}  // namespace credence::internal
