#include "analysis/evidence/verdicts/verdict.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

TEST(VerdictWord, IsInconsistentWhereACovarianceIsAccused) {
  const struct {
    Verdict verdict;
    std::string_view word;
    bool inconsistent;
  } kAll[] = {{Verdict::consistent, "consistent", false},     {Verdict::optimistic, "optimistic", true},
              {Verdict::pessimistic, "pessimistic", true},    {Verdict::mixed, "mixed", true},
              {Verdict::not_gaussian, "not Gaussian", false}, {Verdict::undecided, "undecided", false}};
  for (const auto& [verdict, word, inconsistent] : kAll) {
    EXPECT_EQ(to_string(verdict), word);
    EXPECT_EQ(::testing::PrintToString(verdict), word);
    EXPECT_EQ(is_inconsistent(verdict), inconsistent) << word;
    EXPECT_EQ(is_unsafe(verdict), inconsistent && verdict != Verdict::pessimistic) << word;
    EXPECT_EQ(verdict_named(word), verdict);
  }
  EXPECT_EQ(verdict_named("safe"), std::nullopt);
}

TEST(VerdictWord, JoinsDirections) {
  EXPECT_EQ(direction_of(false, false), Verdict::consistent);
  EXPECT_EQ(direction_of(true, false), Verdict::optimistic);
  EXPECT_EQ(direction_of(false, true), Verdict::pessimistic);
  EXPECT_EQ(direction_of(true, true), Verdict::mixed);
}

}  // namespace
}  // namespace credence::internal
