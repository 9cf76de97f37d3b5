#include "reports/document/replay_tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace credence {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::vector<ReportedReplay> kReplay = [] {
  ReportedReplay replay;
  replay.result.dataset = "carpark";
  return std::vector{replay};
}();

ReplayJudgement judgement(Verdict nees, const NoiseScale& noise) {
  ReplayJudgement j;
  j.nees.verdict.verdict = nees;
  j.nees.verdict.mean = 1.9;
  j.nees.verdict.expected = 2.0;
  j.innovations.noise_scale = noise;
  return j;
}

TEST(ReplayAnswer, InnovationsThatContradictSAreNotBehindAGreenWord) {
  const ReportAnswer answer = replay_answer(
      kReplay, judgement(Verdict::consistent, {.scale = 0.07, .lower = 0.03, .upper = 0.4, .stretches = 5}));
  EXPECT_EQ(answer.tone, CellTone::caution);
  EXPECT_THAT(answer.text, HasSubstr("consistent in position: NEES 1.900 where 2.000 is expected"));
  EXPECT_THAT(answer.text,
              HasSubstr("pessimistic in its innovations: all variances × 0.0700 (0.0300 … 0.400)"));
}

TEST(ReplayAnswer, IsTheWorseOfBoth) {
  const NoiseScale small{.scale = 3.0, .lower = 2.0, .upper = 4.0, .stretches = 5};
  EXPECT_EQ(replay_answer(kReplay, judgement(Verdict::pessimistic, small)).tone, CellTone::alarm);
  EXPECT_EQ(
      replay_answer(kReplay, judgement(Verdict::optimistic, {.scale = 0.5, .lower = 0.4, .upper = 0.6})).tone,
      CellTone::alarm);
}

TEST(ReplayAnswer, SaysNothingOfInnovationsThatFitOrCannotTell) {
  const NoiseScale fits{.scale = 1.1, .lower = 0.8, .upper = 1.4, .stretches = 5};
  const ReportAnswer answer = replay_answer(kReplay, judgement(Verdict::consistent, fits));
  EXPECT_EQ(answer.tone, CellTone::good);
  EXPECT_THAT(answer.text, Not(HasSubstr("innovations")));
  const NoiseScale unknown{.scale = 9.0, .lower = kNaN, .upper = kNaN, .reason = "too short"};
  EXPECT_EQ(replay_answer(kReplay, judgement(Verdict::consistent, unknown)).tone, CellTone::good);
}

}  // namespace
}  // namespace credence
