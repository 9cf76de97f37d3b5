#include "reports/document/replay/replay_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::Not;

ReportAnswer answer_to(Verdict nees, const NoiseScale& noise) {
  ReportedReplay replay;
  replay.result.dataset = "carpark";
  ReplayJudgement judgement;
  judgement.nees.verdict.verdict = nees;
  judgement.nees.verdict.mean = 1.9;
  judgement.nees.verdict.expected = 2.0;
  judgement.innovations.noise_scale = noise;
  judgement.innovations.adjusted_p_value.assign(4, 1.0);
  return replay_document({replay}, judgement).answer;
}

TEST(ReplayAnswer, InnovationsThatContradictSAreNotBehindAGreenWord) {
  const ReportAnswer answer =
      answer_to(Verdict::consistent, {.scale = 0.07, .lower = 0.03, .upper = 0.4, .stretches = 5});
  EXPECT_EQ(answer.tone, CellTone::caution);
  EXPECT_THAT(answer.text, HasSubstr("consistent in position: NEES 1.900 where 2.000 is expected"));
  EXPECT_THAT(answer.text,
              HasSubstr("pessimistic in its innovations: all variances × 0.0700 (0.0300 … 0.400)"));
}

TEST(ReplayAnswer, IsTheWorseOfBoth) {
  const NoiseScale small{.scale = 3.0, .lower = 2.0, .upper = 4.0, .stretches = 5};
  EXPECT_EQ(answer_to(Verdict::pessimistic, small).tone, CellTone::alarm);
  EXPECT_EQ(answer_to(Verdict::optimistic, {.scale = 0.5, .lower = 0.4, .upper = 0.6}).tone, CellTone::alarm);
}

TEST(ReplayAnswer, SaysNothingOfInnovationsThatFitOrCannotTell) {
  const NoiseScale fits{.scale = 1.1, .lower = 0.8, .upper = 1.4, .stretches = 5};
  const ReportAnswer answer = answer_to(Verdict::consistent, fits);
  EXPECT_EQ(answer.tone, CellTone::good);
  EXPECT_THAT(answer.text, Not(HasSubstr("innovations")));
  const NoiseScale unknown{.scale = 9.0, .lower = kNaN, .upper = kNaN, .reason = "too short"};
  EXPECT_EQ(answer_to(Verdict::consistent, unknown).tone, CellTone::good);
}

}  // namespace
}  // namespace credence::internal
