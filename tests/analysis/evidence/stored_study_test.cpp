#include "analysis/evidence/stored_study.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "montecarlo/engine/result_store.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/world_schema.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

/// Of a study of 130 runs a folder holds the 64 from `first` on; without it none.
void store_chunk(const std::filesystem::path& folder, std::optional<std::int64_t> first) {
  constexpr std::int64_t kRuns = 64;
  Scenario scenario = default_scenario("monobot");
  scenario.study.runs = 130;
  scenario.study.steps = 12;
  const Configuration configuration = make_configuration(scenario);
  ResultStore store = ResultStore::open_to_write(folder, "1.2.3");
  store.require_same_scenario(canonical_toml(scenario));
  store.set_name("mine");
  store.put_configuration(configuration.id, configuration_toml(scenario));
  if (first) {
    store.put_chunk({configuration.id, *first, kRuns},
                    to_bytes(configuration.experiment->run_chunk(*first, kRuns)));
  }
  store.commit();
}

TEST(StoredStudy, IsReadAsFarAsItIsThere) {
  const TemporaryFolder folder;
  store_chunk(folder / "out", 0);
  const StoredStudy study = read_study(folder / "out");
  EXPECT_EQ(study.plan.name, "mine");
  EXPECT_EQ(study.tool_version, "1.2.3");
  EXPECT_FALSE(study.is_sweep());
  EXPECT_EQ(study.runs(), 64);
  EXPECT_EQ(study.runs_asked(), 130);
  EXPECT_NO_THROW(require_runs(study));
  const std::vector<StudyAnalysis> analyses = analyse(study);
  ASSERT_EQ(analyses.size(), 1U);
  EXPECT_EQ(analyses.front().statistics.runs, 64);
  EXPECT_FALSE(analyses.front().complete);
}

TEST(StoredStudy, CannotBeJudgedBeforeItsFirstRunsAreThere) {
  const TemporaryFolder folder;
  const auto refusal = [&] {
    try {
      require_runs(read_study(folder / "out"));
    } catch (const StoreError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string out = (folder / "out").string();
  store_chunk(out, std::nullopt);
  EXPECT_EQ(refusal(), out + ": no runs are stored yet");
  store_chunk(out, 64);
  EXPECT_EQ(refusal(), out +
                           ": none of the 64 runs that are stored can be judged yet, as runs 0 to 63 before "
                           "them are missing");
  store_chunk(out, 0);
  EXPECT_EQ(refusal(), "");
}

TEST(StoredStudy, OfWhichNothingIsSaidYetHasNoRuns) {
  const TemporaryFolder folder;
  ResultStore::open_to_write(folder / "out", "1.2.3").commit();
  EXPECT_THROW(
      {
        try {
          read_study(folder / "out");
        } catch (const StoreError& error) {
          EXPECT_EQ(error.what(), (folder / "out").string() + ": no runs are stored yet");
          throw;
        }
      },
      StoreError);
}

TEST(StoredStudy, IsAFolderItselfOrThoseInIt) {
  const TemporaryFolder folder;
  store_chunk(folder / "out/b", 0);
  store_chunk(folder / "out/a", 0);
  std::filesystem::create_directories(folder / "out/c");
  using Paths = std::vector<std::filesystem::path>;
  EXPECT_EQ(study_directories(folder / "out"), (Paths{folder / "out/a", folder / "out/b"}));
  EXPECT_EQ(study_directories(folder / "out/a"), Paths{folder / "out/a"});
  EXPECT_THROW(study_directories(folder / "out/c"), StoreError);
}

}  // namespace
}  // namespace credence::internal
