#include "analysis/evidence/sweep_verdicts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/nan.h"

namespace credence::internal {
namespace {

StudyAnalysis study(double word_p) {
  StudyAnalysis a;
  a.word.p_value = word_p;
  return a;
}

TEST(SweepVerdicts, AdjustTheWordForAllConfigurations) {
  // Benjamini-Yekutieli over three tests by hand, Σ 1/i = 11/6.
  const std::vector<StudyAnalysis> sweep = {study(0.002), study(0.04), study(1.0)};
  const std::vector<double> p = sweep_p_values(sweep);
  EXPECT_NEAR(p[0], 0.002 * 3 * 11.0 / 6.0, 1e-15);
  EXPECT_NEAR(p[1], 0.04 * 1.5 * 11.0 / 6.0, 1e-15);
  EXPECT_EQ(p[2], 1.0);
}

TEST(SweepVerdicts, AnUndecidedConfigurationIsNoMemberOfTheFamily) {
  const std::vector<StudyAnalysis> sweep = {study(kNaN), study(0.01)};
  const std::vector<double> p = sweep_p_values(sweep);
  EXPECT_TRUE(std::isnan(p[0]));
  EXPECT_NEAR(p[1], 0.01, 1e-15);
}

TEST(SweepVerdicts, AStopRuleSpeaksForItsStudy) {
  std::vector<StudyAnalysis> sweep = {study(1e-9)};
  sweep[0].stop.emplace().p_value = 0.3;
  EXPECT_NEAR(sweep_p_values(sweep)[0], 0.3, 1e-15);
}

}  // namespace
}  // namespace credence::internal
