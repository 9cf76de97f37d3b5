#include "reports/document/glossary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace credence::internal {
namespace {

using testing::Contains;
using testing::IsEmpty;

TEST(Glossary, HasTheWordsOfTheReportsOnceAndInOrder) {
  for (const char* word : {"NEES",           "NIS",          "ANEES",
                           "pairwise",       "least trace",  "anchor",
                           "monobot",        "optimistic",   "pessimistic",
                           "mixed",          "consistent",   "undecided",
                           "not Gaussian",   "conformal",    "protection level",
                           "log score",      "exchangeable", "bias",
                           "outliers",       "bound",        "stretches",
                           "Clopper-Pearson"}) {
    EXPECT_NE(find_glossary_word(word), nullptr) << word;
  }
  std::set<std::string_view> seen;
  for (const GlossaryWord& entry : glossary()) {
    EXPECT_TRUE(seen.insert(entry.word).second) << entry.word;
    EXPECT_FALSE(entry.short_form.empty() || entry.says.empty()) << entry.word;
    EXPECT_FALSE(entry.short_form.ends_with('.')) << entry.word;
    EXPECT_TRUE(entry.says.ends_with('.')) << entry.word;
    EXPECT_EQ(find_glossary_word(entry.word), &entry) << "two entries answer to it";
  }
}

TEST(Glossary, FindsOtherSpellings) {
  EXPECT_EQ(find_glossary_word("nees"), find_glossary_word("NEES"));
  EXPECT_EQ(find_glossary_word("conservative"), find_glossary_word("pessimistic"));
  EXPECT_EQ(find_glossary_word("P"), find_glossary_word("covariance"));
  EXPECT_EQ(find_glossary_word("nose"), nullptr);
}

TEST(Glossary, ProposesNearWords) {
  EXPECT_THAT(near_glossary_words("optimstic"), Contains("optimistic"));
  EXPECT_THAT(near_glossary_words("nees?"), Contains("NEES"));
  EXPECT_THAT(near_glossary_words("anch"), Contains("anchor"));
  EXPECT_LE(near_glossary_words("covariance").size(), 3u);
  EXPECT_THAT(near_glossary_words("zyzzyva"), IsEmpty());
}

TEST(Glossary, SeesWholeWordsAndTheLongest) {
  const std::string text = "not Gaussian, NEES_mean, σNIS and (NIS)";
  const std::vector<GlossaryUse> uses = glossary_uses(text);
  ASSERT_EQ(uses.size(), 2u);
  EXPECT_EQ(uses[0].word->word, "not Gaussian");
  EXPECT_EQ(text.substr(uses[1].begin - 1, uses[1].length + 2), "(NIS)");
}

}  // namespace
}  // namespace credence::internal
