#include "analysis/evidence/sums/evidence_bytes.h"

#include <gmock/gmock.h>

#include <atomic>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sums/evidence_collect.h"
#include "montecarlo/engine/result_store.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

Scenario small_study(const std::string& world, std::vector<std::string> overrides) {
  overrides.emplace_back("study.runs=10");
  overrides.emplace_back("study.steps=60");
  return load_scenario_text("[world]\nmodel = \"" + world + "\"\n", "t.toml", overrides);
}

std::vector<Scenario> small_studies() {
  return {
      small_study("planar", {"world.landmarks=4"}),
      small_study("planar", {"world.landmarks=4", "world.sensor_range=7", "noise.detection_probability=0.6"}),
      small_study("monobot", {}), small_study("tracking", {"world.sensor=range_bearing"}),
      small_study("localisation", {"world.aiding=landmarks", "world.aiding_interval=10"})};
}

Evidence evidence_of(const Experiment& experiment) {
  return EvidenceCollector(experiment, 10).take(10).value();
}

TEST(EvidenceBytes, AreReadAsTheyWereWritten) {
  for (const Scenario& scenario : small_studies()) {
    const auto experiment = make_experiment(scenario);
    const Evidence evidence = evidence_of(*experiment);
    const std::vector<std::byte> bytes = to_bytes(evidence);
    const Evidence read = evidence_from_bytes(bytes, experiment->layout());
    EXPECT_EQ(to_bytes(read), bytes);
    // All that it says, and what it becomes with more of it.
    Evidence twice = read, once = evidence;
    twice.merge(evidence);
    once.merge(evidence);
    EXPECT_EQ(to_bytes(twice), to_bytes(once));
    const Judgement a = judge(evidence), b = judge(read);
    ASSERT_EQ(a.tests.size(), b.tests.size());
    for (std::size_t i = 0; i < a.tests.size(); ++i) {
      EXPECT_EQ(a.tests[i].says, b.tests[i].says);
      EXPECT_THAT(a.tests[i].p_value, testing::NanSensitiveDoubleEq(b.tests[i].p_value));
    }
  }
}

TEST(EvidenceBytes, ThatAreNotOursAreRefused) {
  const auto experiment = make_experiment(small_studies()[1]);
  const auto other = make_experiment(small_studies()[3]);
  std::vector<std::byte> bytes = to_bytes(evidence_of(*experiment));
  EXPECT_THROW(evidence_from_bytes(bytes, other->layout()), std::runtime_error);
  EXPECT_THROW(evidence_from_bytes({}, experiment->layout()), std::runtime_error);
  for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 500) {
    EXPECT_THROW(evidence_from_bytes(std::span(bytes).first(size), experiment->layout()), std::runtime_error);
  }
  std::vector<std::byte> longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_THROW(evidence_from_bytes(longer, experiment->layout()), std::runtime_error);
  bytes[0] ^= std::byte{1};
  EXPECT_THROW(evidence_from_bytes(bytes, experiment->layout()), std::runtime_error);
}

// 21 was without the units of the states.
TEST(EvidenceBytes, UnitsAreKeptAndThoseOfAVersionWithoutThemAreRefused) {
  const auto experiment = make_experiment(small_study("tracking", {}));
  const Evidence evidence = evidence_of(*experiment);
  std::vector<std::byte> bytes = to_bytes(evidence);
  EXPECT_EQ(evidence_from_bytes(bytes, experiment->layout()).layout.units,
            (std::vector<std::string>{"m", "m", "m/s", "m/s"}));
  Evidence in_feet = evidence;
  in_feet.layout.units[0] = "ft";
  EXPECT_THROW(evidence_from_bytes(to_bytes(in_feet), experiment->layout()), std::runtime_error);
  EXPECT_EQ(evidence_from_bytes(to_bytes(in_feet), in_feet.layout).layout.units[0], "ft");
  ASSERT_EQ(bytes[0], std::byte{25});
  bytes[0] = std::byte{21};
  EXPECT_THROW(evidence_from_bytes(bytes, experiment->layout()), std::runtime_error);
}

// They would be added to those of another size.
TEST(EvidenceBytes, SumsOfAnotherSizeThanTheStateAreRefused) {
  const auto experiment = make_experiment(small_studies()[0]);
  const Evidence evidence = evidence_of(*experiment);
  for (Matrix StretchSums::*sum : {&StretchSums::square, &StretchSums::across, &StretchSums::between}) {
    Evidence changed = evidence;
    changed.law.stretches.*sum = Matrix::Ones(1, 1);
    EXPECT_THROW(evidence_from_bytes(to_bytes(changed), experiment->layout()), std::runtime_error);
  }
}

// Whatever stands there is refused or can be merged and judged.
TEST(EvidenceBytes, ThatWereChangedDoNoHarm) {
  const auto experiment = make_experiment(small_studies()[1]);
  const Evidence evidence = evidence_of(*experiment);
  const std::vector<std::byte> bytes = to_bytes(evidence);
  std::mt19937_64 random(3);
  int refused = 0, read = 0;
  for (int i = 0; i < 600; ++i) {
    std::vector<std::byte> changed = bytes;
    const int changes = 1 + static_cast<int>(random() % 3);
    for (int k = 0; k < changes; ++k) {
      // Half of them where counts and names are.
      const std::size_t range = k % 2 == 0 ? changed.size() : std::min<std::size_t>(changed.size(), 4000);
      changed[random() % range] = static_cast<std::byte>(random() % 256);
    }
    try {
      Evidence all = evidence;
      all.merge(evidence_from_bytes(changed, experiment->layout()));
      judge(all);
      ++read;
    } catch (const std::runtime_error&) {
      ++refused;
    } catch (const std::invalid_argument&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 30);
  EXPECT_GT(read, 30);
}

/// Counts what is played.
class CountedExperiment final : public Experiment {
 public:
  explicit CountedExperiment(const Experiment& inner) : Experiment(inner.layout()), inner_(inner) {}
  StudyStatistics run_chunk(std::int64_t first, std::int64_t runs) const override {
    ++played;
    return inner_.run_chunk(first, runs);
  }
  Outcome visit(std::int64_t run, const StepVisitor& take) const override { return inner_.visit(run, take); }
  bool shows_as_it_runs() const override { return inner_.shows_as_it_runs(); }
  std::optional<StudyStatistics> show_chunk(std::int64_t first, std::int64_t runs,
                                            ChunkObserver& observer) const override {
    ++shown;
    return inner_.show_chunk(first, runs, observer);
  }
  RunTrace describe_world() const override { return inner_.describe_world(); }

  mutable std::atomic<int> played = 0, shown = 0;

 private:
  const Experiment& inner_;
};

TEST(EvidenceCollector, KeepsEvidenceInTheStoreAndTakesItFromThere) {
  for (const char* world : {"planar", "monobot"}) {
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / (std::string("evidence-") + world);
    std::filesystem::remove_all(folder);
    Scenario scenario = small_study(world, {});
    scenario.study.runs = 100;
    const auto inner = make_experiment(scenario);
    std::vector<std::byte> first, second;
    for (std::vector<std::byte>* bytes : {&first, &second}) {
      const CountedExperiment experiment(*inner);
      ResultStore store = ResultStore::open_to_write(folder, "1");
      store.put_configuration("c", "text");
      EvidenceCollector collector(experiment, 100);
      StudyTask task{.id = "c", .experiment = &experiment, .runs = 100};
      collector.keep_with(task);
      run_studies({&task, 1}, {.threads = 2, .store = &store});
      const int shown = experiment.shown;
      *bytes = to_bytes(collector.take(100).value());
      EXPECT_EQ(experiment.shown, shown) << world;
      EXPECT_EQ(shown, bytes == &first ? 2 : 0) << world;
      if (bytes == &second) EXPECT_EQ(experiment.played, 0) << world;
    }
    EXPECT_EQ(first, second) << world;
    std::filesystem::remove_all(folder);
  }
}

// The chunk is refused by whoever reads it.
TEST(EvidenceCollector, DoesNotTakeWhatIsOfOtherRuns) {
  const auto experiment = make_experiment(small_studies()[0]);
  EvidenceCollector collector(*experiment, 100);
  const std::vector<std::byte> of_ten = to_bytes(evidence_of(*experiment));
  EXPECT_TRUE(collector.take_stored(0, 10, of_ten));
  EXPECT_FALSE(collector.take_stored(0, kChunkRuns, of_ten));
  EXPECT_EQ(collector.first_runs(), 0);
}

// What is stored by a version to come is played again.
TEST(EvidenceCollector, PlaysWhatItCannotRead) {
  const auto inner = make_experiment(small_studies()[0]);
  const CountedExperiment experiment(*inner);
  EvidenceCollector collector(experiment, 10);
  std::vector<std::byte> bytes = to_bytes(evidence_of(*inner));
  bytes[0] ^= std::byte{2};
  EXPECT_TRUE(collector.take_stored(0, 10, bytes)) << "it may be of these runs";
  EXPECT_EQ(to_bytes(collector.take(10).value()), to_bytes(evidence_of(*inner)));
  EXPECT_EQ(experiment.shown, 1);
}

}  // namespace
}  // namespace credence::internal
