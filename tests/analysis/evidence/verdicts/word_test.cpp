#include "analysis/evidence/verdicts/word.h"

#include <gmock/gmock.h>

#include <cmath>

#include "core/nan.h"

namespace credence::internal {
namespace {

/// A verdict of 100 steps that says this of each direction.
ConsistencyVerdict says(double optimistic, double pessimistic) {
  ConsistencyVerdict v;
  v.confidence = 0.95;
  v.optimistic_p_value = optimistic;
  v.pessimistic_p_value = pessimistic;
  v.p_value = std::min(optimistic, pessimistic);
  v.verdict = v.p_value > 0.05                            ? Verdict::consistent
              : optimistic <= 0.05 && pessimistic <= 0.05 ? Verdict::mixed
              : optimistic <= 0.05                        ? Verdict::optimistic
                                                          : Verdict::pessimistic;
  v.count = v.steps_tested = 100;
  v.steps.resize(100);
  return v;
}

ConsistencyVerdict no_data() {
  ConsistencyVerdict v = says(kNaN, kNaN);
  v.verdict = Verdict::undecided;
  v.count = v.steps_tested = 0;
  return v;
}

Word word_of(const ConsistencyVerdict& nees, const ConsistencyVerdict& nis,
             std::span<const BlockVerdict> blocks, double confidence) {
  return join_verdicts(word_parts(nees, nis, blocks), confidence);
}

TEST(Word, IsConsistentWhereNothingSpeaks) {
  const Word word = word_of(says(0.3, 0.9), says(0.6, 0.5), {}, 0.95);
  EXPECT_EQ(word.verdict, Verdict::consistent);
  EXPECT_EQ(word.says, "");
}

TEST(Word, OfOneStepNothingIsSaidOfWhen) {
  ConsistencyVerdict one = says(1e-9, 1.0);
  one.count = one.steps_tested = 1;
  one.steps.resize(1);
  EXPECT_EQ(word_of(one, says(1.0, 1.0), {}, 0.95).says, "optimistic in NEES");
  EXPECT_EQ(word_of(one, says(1.0, 1.0), {}, 0.95).named, std::vector<std::string>{"NEES"});
}

TEST(Word, OfSeveralSensorsTheFirstIsNamedAndTheOthersCounted) {
  const ConsistencyVerdict wrong = says(1e-9, 1.0), worse = says(1e-12, 1.0), right = says(1.0, 1.0);
  std::vector<WordPart> parts = {{"NIS of gps", &wrong, 0.1, false, true},
                                 {"NIS of baro", &worse, 0.1, false, true}};
  EXPECT_THAT(join_verdicts(parts, 0.95).says, ::testing::StartsWith("optimistic in NIS of baro"));
  EXPECT_THAT(join_verdicts(parts, 0.95).says, ::testing::EndsWith(", and of 1 more sensor"));
  parts.push_back({"NIS of mag", &wrong, 0.1, false, true});
  parts.push_back({"component 1 of mag", &wrong, 0.1, false, true, true});
  EXPECT_THAT(join_verdicts(parts, 0.95).says, ::testing::EndsWith(", and of 2 more sensors"));
  parts = {{"NIS of gps", &right, 0.1, false, true}, {"NIS of baro", &worse, 0.1, false, true}};
  EXPECT_THAT(join_verdicts(parts, 0.95).says, ::testing::Not(::testing::EndsWith("sensor")));
}

TEST(Word, ADirectionHasANameOnEachSide) {
  const ConsistencyVerdict both = says(1e-9, 1e-9);
  const std::vector<WordPart> parts = {
      {.name = "the direction of a", .verdict = &both, .says_where = true, .pessimistic_name = "that of b"}};
  const Word word = join_verdicts(parts, 0.95);
  EXPECT_EQ(word.says,
            "optimistic in the direction of a on average over the steps; pessimistic in that of b on average "
            "over the steps");
  EXPECT_EQ(word.named, (std::vector<std::string>{"the direction of a", "that of b"}));
}

TEST(Word, AtOthersIsSaidBesideAtSomeTimes) {
  const ConsistencyVerdict up = says(1e-9, 1.0), down = says(1.0, 1e-9);
  const auto part = [](const char* name, const ConsistencyVerdict& v) {
    return WordPart{.name = name, .verdict = &v, .named_last = true};
  };
  const auto named = [](std::vector<WordPart> parts) { return join_verdicts(parts, 0.95).named; };
  EXPECT_EQ(named({part("NEES at some times", up), part("NEES at others", down)}),
            (std::vector<std::string>{"NEES at some times", "NEES at others"}));
  EXPECT_EQ(named({part("NEES at others", down)}), std::vector<std::string>{"NEES at some times"});
  EXPECT_EQ(named({part("NIS at some times", up), part("NEES at others", down)}),
            (std::vector<std::string>{"NIS at some times", "NEES at some times"}));
}

TEST(Word, HoldsItsLevelByTheWeightsOfItsParts) {
  // NEES has two thirds where there is no block: 0.02 / (2/3) = 0.03; NIS one third: 0.02 · 3 = 0.06.
  EXPECT_NEAR(word_of(says(0.02, 1.0), says(1.0, 1.0), {}, 0.95).p_value, 0.03, 1e-12);
  EXPECT_NEAR(word_of(says(1.0, 1.0), says(0.02, 1.0), {}, 0.95).p_value, 0.06, 1e-12);
  EXPECT_EQ(word_of(says(0.02, 1.0), says(1.0, 1.0), {}, 0.95).verdict, Verdict::optimistic);
  EXPECT_EQ(word_of(says(1.0, 1.0), says(0.02, 1.0), {}, 0.95).verdict, Verdict::consistent);
}

TEST(Word, TellsWhetherItIsOfSAlone) {
  EXPECT_TRUE(word_of(says(1.0, 1.0), says(1.0, 1e-6), {}, 0.95).of_S_alone);
  EXPECT_FALSE(word_of(says(1.0, 1e-6), says(1.0, 1e-6), {}, 0.95).of_S_alone);
  EXPECT_FALSE(word_of(says(1.0, 1.0), says(1.0, 1.0), {}, 0.95).of_S_alone);
  const std::vector<BlockVerdict> blocks = {{"map", says(1.0, 1e-12)}};
  EXPECT_FALSE(word_of(says(1.0, 1.0), says(1.0, 1e-6), blocks, 0.95).of_S_alone);
}

TEST(Word, AComponentOfInnovationsIsNamedWhereNoOtherPartIs) {
  const ConsistencyVerdict nees = says(0.3, 0.4), right = says(0.5, 0.6), wrong = says(1e-4, 1.0),
                           large = says(1e-9, 1.0), small = says(1.0, 1e-9);
  const auto word_with = [&](const ConsistencyVerdict& nis) {
    std::vector<WordPart> parts = word_parts(nees, nis, {});
    parts.push_back({"component 1", &large, 0.05, false, true, true});
    parts.push_back({"component 2", &small, 0.05, false, true, true});
    return join_verdicts(parts, 0.95);
  };
  EXPECT_EQ(
      word_with(right).says,
      "optimistic in component 1 on average over the steps; pessimistic in component 2 on average over the "
      "steps");
  EXPECT_TRUE(word_with(right).of_S_alone);
  EXPECT_EQ(
      word_with(wrong).says,
      "optimistic in NIS on average over the steps; pessimistic in component 2 on average over the steps");
}

TEST(Word, WithoutTruthNisHasTheWholeLevel) {
  const Word word = word_of(no_data(), says(1.0, 0.04), {}, 0.95);
  EXPECT_EQ(word.verdict, Verdict::pessimistic);
  EXPECT_NEAR(word.p_value, 0.04, 1e-12);
  EXPECT_TRUE(std::isnan(word.joined[0].p_value));
  EXPECT_EQ(word_of(no_data(), no_data(), {}, 0.95).verdict, Verdict::undecided);
}

TEST(Word, ABlockThatIsOptimisticIsNeverCalledPessimistic) {
  ConsistencyVerdict heading = says(1e-9, 1.0);
  heading.optimistic_steps = {.first = 40, .last = 100, .count = 50};
  const std::vector<BlockVerdict> blocks = {{"heading", heading}, {"map", says(1.0, 1e-12)}};
  const Word word = word_of(says(1.0, 1e-9), says(1.0, 1e-9), blocks, 0.95);
  EXPECT_EQ(word.verdict, Verdict::mixed);
  EXPECT_EQ(word.says, "optimistic in heading from step 40 on; pessimistic in map on average over the steps");
}

TEST(Word, SaysWhen) {
  ConsistencyVerdict v = says(0.001, 1.0);
  v.decided_by_steps = true;
  v.optimistic_steps = {.first = 11, .last = 11, .count = 1};
  EXPECT_EQ(when_text(v, Verdict::optimistic), "at step 11");
  v.optimistic_steps = {.first = 1, .last = 3, .count = 3};
  EXPECT_EQ(when_text(v, Verdict::optimistic), "in steps 1 to 3");
  v.optimistic_steps = {.first = 1, .last = 100, .count = 90};
  EXPECT_EQ(when_text(v, Verdict::optimistic), "throughout");
}

// Of a mistake that is there at all times, a few steps reject as well as the mean.
TEST(Word, WhereTheMeanDecidesFewStepsDoNotSayWhen) {
  ConsistencyVerdict v = says(0.001, 1.0);
  v.steps_tested = 300;
  v.steps.resize(300);
  const auto when = [&](std::int64_t first, std::int64_t last, std::int64_t count) {
    v.optimistic_steps = {.first = first, .last = last, .count = count};
    return when_text(v, Verdict::optimistic);
  };
  EXPECT_EQ(when(141, 141, 1), "on average over the steps");
  EXPECT_EQ(when(38, 162, 4), "on average over the steps");
  EXPECT_EQ(when(2, 6, 4), "from step 2 on") << "close together";
  EXPECT_EQ(when(38, 300, 40), "from step 38 on");
  v.decided_by_steps = true;
  EXPECT_EQ(when(141, 141, 1), "at step 141");
}

TEST(Word, AnUndecidedPartLeavesItUndecidedUnlessAnotherRejects) {
  ConsistencyVerdict open = says(0.3, 0.9);
  open.verdict = Verdict::undecided;
  EXPECT_EQ(word_of(open, says(0.5, 0.6), {}, 0.95).verdict, Verdict::undecided);
  EXPECT_EQ(word_of(open, says(1e-6, 1.0), {}, 0.95).verdict, Verdict::optimistic);
}

}  // namespace
}  // namespace credence::internal
