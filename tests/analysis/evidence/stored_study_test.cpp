#include "analysis/evidence/stored_study.h"

#include <gtest/gtest.h>

#include "montecarlo/engine/result_store.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/world_schema.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

/// Plays a study of 130 runs of which a folder holds the first 64.
void store_first_chunk(const std::filesystem::path& folder) {
  Scenario scenario = default_scenario("monobot");
  scenario.study.runs = 130;
  scenario.study.steps = 12;
  const Configuration configuration = make_configuration(scenario);
  ResultStore store = ResultStore::open_to_write(folder, "1.2.3");
  store.require_same_scenario(canonical_toml(scenario));
  store.set_name("mine");
  store.put_configuration(configuration.id, configuration_toml(scenario));
  store.put_chunk({configuration.id, 0, 64}, to_bytes(configuration.experiment->run_chunk(0, 64)));
  store.commit();
}

TEST(StoredStudy, IsReadAsFarAsItIsThere) {
  const TemporaryFolder folder;
  store_first_chunk(folder / "out");
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

TEST(StoredStudy, IsAFolderItselfOrThoseInIt) {
  const TemporaryFolder folder;
  store_first_chunk(folder / "out/b");
  store_first_chunk(folder / "out/a");
  std::filesystem::create_directories(folder / "out/c");
  using Paths = std::vector<std::filesystem::path>;
  EXPECT_EQ(study_directories(folder / "out"), (Paths{folder / "out/a", folder / "out/b"}));
  EXPECT_EQ(study_directories(folder / "out/a"), Paths{folder / "out/a"});
  EXPECT_THROW(study_directories(folder / "out/c"), StoreError);
}

}  // namespace
}  // namespace credence::internal
