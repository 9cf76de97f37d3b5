#include "analysis/evidence/sweep_verdicts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/nan.h"

namespace credence {
namespace {

StudyAnalysis study(double nees_p, double nis_p) {
  StudyAnalysis a;
  a.nees.p_value = nees_p;
  a.nis.p_value = nis_p;
  return a;
}

TEST(SweepVerdicts, JoinBothStatisticsAndAdjustForAllConfigurations) {
  // By hand: 2·0.001 = 0.002, 2·0.02 = 0.04, 1; Benjamini-Yekutieli over three tests, Σ 1/i = 11/6.
  const std::vector<StudyAnalysis> sweep = {study(0.001, 0.5), study(0.9, 0.02), study(0.7, 0.8)};
  const std::vector<double> p = sweep_p_values(sweep);
  EXPECT_NEAR(p[0], 0.002 * 3 * 11.0 / 6.0, 1e-15);
  EXPECT_NEAR(p[1], 0.04 * 1.5 * 11.0 / 6.0, 1e-15);
  EXPECT_EQ(p[2], 1.0);
}

TEST(SweepVerdicts, AnUndecidedConfigurationIsNoMemberOfTheFamily) {
  const std::vector<StudyAnalysis> sweep = {study(kNaN, kNaN), study(0.01, kNaN)};
  const std::vector<double> p = sweep_p_values(sweep);
  EXPECT_TRUE(std::isnan(p[0]));
  EXPECT_NEAR(p[1], 0.01, 1e-15);
}

TEST(SweepVerdicts, AStopRuleSpeaksForItsStudy) {
  std::vector<StudyAnalysis> sweep = {study(1e-9, 1e-9)};
  sweep[0].stop.emplace().p_value = 0.3;
  EXPECT_NEAR(sweep_p_values(sweep)[0], 0.3, 1e-15);
}

}  // namespace
}  // namespace credence
