#include "reports/document/glossary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "analysis/evidence/causes/advice_cause.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study/study_report.h"
#include "reports/document/sweep/sweep_report.h"
#include "tests/reports/document/synthetic_logs.h"

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

TEST(Glossary, FindsItsWordsInAPhrase) {
  const auto words = [](std::string_view phrase) {
    std::vector<std::string_view> found;
    for (const GlossaryWord* word : glossary_words_in(phrase)) found.push_back(word->word);
    return found;
  };
  EXPECT_THAT(words("NEES of the pose"), testing::ElementsAre("NEES", "pose"));
  EXPECT_THAT(words("p"), testing::ElementsAre("p-value"));
  EXPECT_THAT(words("P"), testing::ElementsAre("covariance"));
  EXPECT_THAT(words("prune"), IsEmpty());
}

TEST(Glossary, EverydayWordsAreExplainedAndNotMarked) {
  ASSERT_NE(find_glossary_word("stands"), nullptr);
  EXPECT_THAT(glossary_uses("stands: in all runs together"), IsEmpty());
}

/// Whether `explain` has something to say of it.
bool is_explained(std::string_view phrase) { return !glossary_words_in(phrase).empty(); }

TEST(Glossary, ExplainsEveryVerdictOutcomeCauseAndTest) {
  for (int i = 0; i <= static_cast<int>(Verdict::undecided); ++i)
    EXPECT_NE(find_glossary_word(to_string(static_cast<Verdict>(i))), nullptr) << i;
  for (const Outcome outcome : kOutcomes) {
    if (outcome != Outcome::ok) EXPECT_TRUE(is_explained(to_string(outcome))) << to_string(outcome);
  }
  const int causes = static_cast<int>(Cause::inflation) + 1;
  EXPECT_EQ(to_string(static_cast<Cause>(causes)), "unknown") << "there are more";
  for (int i = 0; i < causes; ++i) {
    const std::string_view cause = to_string(static_cast<Cause>(i));
    EXPECT_TRUE(is_explained(cause)) << cause;
  }
  const CheckedLogs logs = synthetic_logs(Defect::none);
  for (const NamedTest& test : logs.analysis.judgement.tests)
    EXPECT_TRUE(is_explained(test.name)) << test.name;
}

/// Titles of the columns of its tables that neither the glossary nor a note of the table explains; settings
/// are named by their keys.
std::vector<std::string> unexplained_columns(const Document& document) {
  std::vector<std::string> titles;
  for (const DocumentPart& part : document.parts()) {
    const auto* table = std::get_if<ReportTable>(&part);
    if (table == nullptr) continue;
    for (const TableColumn& column : table->columns) {
      const bool noted = std::ranges::any_of(table->notes, [&](const std::string& note) {
        return note.find(column.title + ": ") != std::string::npos;
      });
      if (!column.title.empty() && column.title.find('.') == std::string::npos && !noted &&
          !is_explained(column.title))
        titles.push_back(column.title);
    }
  }
  return titles;
}

TEST(Glossary, ExplainsEveryColumnOfTheTablesOfAStudyASweepAndLogs) {
  EXPECT_THAT(unexplained_columns(log_document(synthetic_logs(Defect::none))), IsEmpty());
  SweepPlan plan =
      plan_sweep(read_scenario_text("[world]\nmodel = \"planar\"\nlandmarks = 2\n[study]\nruns = 8\nsteps = "
                                    "6\n[sweep]\nnoise.range_std = [0.1, 1]\n",
                                    "sweep.toml"));
  std::vector<StudyAnalysis> studies;
  for (const SweepPoint& point : plan.points) {
    const auto experiment = make_experiment(point.scenario);
    const StudyTask task{"", experiment.get(), point.scenario.study.runs};
    studies.push_back(
        analyse_study(point.scenario, *experiment, std::move(run_studies({&task, 1}, {}).front())));
    add_judgement(studies.back(), *experiment, {});
  }
  EXPECT_THAT(unexplained_columns(study_document({{.analysis = studies.front()}})), IsEmpty());
  EXPECT_THAT(unexplained_columns(sweep_document(analyse_sweep(std::move(plan), std::move(studies)))),
              IsEmpty());
}

}  // namespace
}  // namespace credence::internal
