#include "montecarlo/engine/engine.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <thread>

#include "core/stop_point.h"
#include "montecarlo/engine/packed_bytes.h"
#include "montecarlo/engine/result_store.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/linear/linear_experiment.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

Scenario monobot(std::int64_t runs) {
  Scenario s = default_scenario("monobot");
  s.study.runs = runs;
  s.study.steps = 20;
  return s;
}

Scenario small_planar(std::int64_t runs) {
  Scenario s = default_scenario("planar");
  s.world.landmarks = 4;
  s.study.runs = runs;
  s.study.steps = 15;
  return s;
}

StudyStatistics run(const Experiment& experiment, std::int64_t runs, int threads) {
  const StudyTask task{"a", &experiment, runs};
  EngineOptions options;
  options.threads = threads;
  std::vector<StudyResult> results = run_studies({&task, 1}, options);
  EXPECT_TRUE(results.front().complete);
  return results.front().statistics;
}

class TempDirectory {
 public:
  TempDirectory()
      : path_(fs::temp_directory_path() / ("credence-engine-" + std::to_string(::getpid()) + "-" +
                                           testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(path_);
  }
  ~TempDirectory() { fs::remove_all(path_); }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

TEST(Engine, BitsDoNotDependOnTheNumberOfThreads) {
  for (const Scenario& scenario : {monobot(1000), small_planar(150)}) {
    const auto experiment = make_experiment(scenario);
    const StudyStatistics one = run(*experiment, scenario.study.runs, 1);
    EXPECT_EQ(one.runs, scenario.study.runs);
    for (const int threads : {2, 3, 7})
      EXPECT_EQ(run(*experiment, scenario.study.runs, threads), one) << threads;
  }
}

TEST(Engine, InterruptedAndResumedIsTheSameAsUninterrupted) {
  const Scenario scenario = monobot(1000);
  const auto experiment = make_experiment(scenario);
  const StudyTask task{configuration_id(scenario), experiment.get(), scenario.study.runs};
  const TempDirectory directory;

  std::atomic<bool> stop{false};
  std::int64_t done = 0;
  {
    ResultStore store = ResultStore::open_to_write(directory.path(), "test");
    store.require_same_scenario(canonical_toml(scenario));
    store.put_configuration(task.id, configuration_toml(scenario));
    EngineOptions options;
    options.threads = 2;
    options.store = &store;
    options.stop = &stop;
    options.progress = [&](const StudyProgress& p) {
      done = p.runs_done;
      if (done >= 300) stop = true;
    };
    const StudyResult partial = run_studies({&task, 1}, options).front();
    EXPECT_FALSE(partial.complete);
    EXPECT_GE(done, 300);
    EXPECT_LT(done, 1000);
    // What is reported is a prefix, itself the same as a shorter study.
    EXPECT_EQ(partial.statistics.runs % kChunkRuns, 0);
    EXPECT_EQ(partial.statistics, run(*experiment, partial.statistics.runs, 1));
  }
  ResultStore store = ResultStore::open_to_write(directory.path(), "test");
  EngineOptions options;
  options.store = &store;
  std::int64_t stored = 0;
  options.progress = [&](const StudyProgress& p) { stored = p.runs_stored; };
  const StudyResult resumed = run_studies({&task, 1}, options).front();
  EXPECT_EQ(stored, done);
  EXPECT_TRUE(resumed.complete);
  EXPECT_EQ(resumed.statistics, run(*experiment, 1000, 1));
}

// A world whose one chunk lasts a while.
class SlowExperiment : public Experiment {
 public:
  explicit SlowExperiment(const Experiment& quick) : Experiment(quick.layout()), quick_(quick) {}
  StudyStatistics run_chunk(std::int64_t first_run, std::int64_t runs) const override {
    for (int step = 0; step < 20; ++step) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      stop_point(runs);
    }
    return quick_.run_chunk(first_run, runs);
  }
  RunTrace describe_world() const override { return quick_.describe_world(); }
  Outcome visit(std::int64_t run, const StepVisitor& take) const override { return quick_.visit(run, take); }

 private:
  const Experiment& quick_;
};

TEST(Engine, ALongChunkIsSeenWhileItIsInHand) {
  const auto quick = make_experiment(monobot(64));
  const SlowExperiment slow(*quick);
  std::vector<StudyProgress> seen;
  EngineOptions options;
  options.threads = 1;
  options.progress = [&](const StudyProgress& p) { seen.push_back(p); };
  const StudyTask task{.id = "a", .experiment = &slow, .runs = 64, .steps = 20};
  const StudyResult result = run_studies({&task, 1}, options).front();
  EXPECT_EQ(result.statistics, run(*quick, 64, 1));
  const auto in_hand =
      std::ranges::find_if(seen, [](const StudyProgress& p) { return p.runs_in_hand > 0.0; });
  ASSERT_NE(in_hand, seen.end());
  EXPECT_LT(in_hand->runs_in_hand, 64.0);
  EXPECT_EQ(in_hand->runs_done, 0);
  EXPECT_EQ(seen.back().runs_done, 64);
  EXPECT_EQ(seen.back().runs_in_hand, 0.0) << "what is done is no longer in hand";
}

TEST(Engine, ShardsTogetherAreTheWhole) {
  const Scenario scenario = monobot(500);
  const auto experiment = make_experiment(scenario);
  const StudyTask task{configuration_id(scenario), experiment.get(), scenario.study.runs};
  const TempDirectory directory;
  ResultStore store = ResultStore::open_to_write(directory.path(), "test");
  store.put_configuration(task.id, configuration_toml(scenario));
  for (const int shard : {2, 1, 3}) {
    EngineOptions options;
    options.store = &store;
    options.shard = shard;
    options.shards = 3;
    run_studies({&task, 1}, options);
  }
  EngineOptions options;
  options.store = &store;
  std::int64_t done = 0;
  options.progress = [&](const StudyProgress& p) { done = p.runs_done; };
  const StudyResult whole = run_studies({&task, 1}, options).front();
  EXPECT_EQ(done, 0) << "nothing is left to run";
  EXPECT_EQ(whole.statistics, run(*experiment, 500, 2));
}

TEST(Engine, AWatchEndsAStudyAtTheSameRunWhateverTheThreadsDid) {
  const auto experiment = make_experiment(monobot(100000));
  for (const int threads : {1, 2, 7}) {
    std::vector<std::int64_t> seen;
    const StudyTask watched{.id = "a",
                            .experiment = experiment.get(),
                            .runs = 100000,
                            .enough = [&](const StudyStatistics& chunk, const StudyStatistics& prefix) {
                              EXPECT_EQ(chunk.runs, kChunkRuns);
                              seen.push_back(prefix.runs);
                              return prefix.runs >= 5 * kChunkRuns;
                            }};
    const StudyTask other{"b", experiment.get(), 300};
    const StudyTask tasks[] = {watched, other};
    EngineOptions options;
    options.threads = threads;
    std::int64_t total = 0;
    options.progress = [&](const StudyProgress& p) { total = p.runs_total; };
    const std::vector<StudyResult> results = run_studies(tasks, options);
    EXPECT_EQ(seen, (std::vector<std::int64_t>{64, 128, 192, 256, 320})) << threads;
    EXPECT_TRUE(results[0].complete);
    EXPECT_FALSE(results[0].timed_out);
    EXPECT_EQ(results[0].statistics, run(*experiment, 320, 1));
    EXPECT_EQ(results[1].statistics, run(*experiment, 300, 1));
    EXPECT_EQ(total, 620);
  }
}

TEST(Engine, AWatchedStudyEndsAtTheSameRunWhenItIsResumed) {
  const Scenario scenario = monobot(1000);
  const auto experiment = make_experiment(scenario);
  const TempDirectory directory;
  ResultStore store = ResultStore::open_to_write(directory.path(), "test");
  StudyTask task{configuration_id(scenario), experiment.get(), 1000};
  store.put_configuration(task.id, configuration_toml(scenario));
  EngineOptions options;
  options.store = &store;
  run_studies({&task, 1}, options);  // all of it is there, and more than is wanted
  task.enough = [](const StudyStatistics&, const StudyStatistics& prefix) { return prefix.runs >= 128; };
  const StudyResult result = run_studies({&task, 1}, options).front();
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(result.statistics, run(*experiment, 128, 1));
}

// Such a chunk has a checksum that fits. Runs that all went well do not tell which they are.
TEST(Engine, AStoredChunkThatIsAnothersIsRefused) {
  const Scenario scenario = monobot(128);
  const auto experiment = make_experiment(scenario);
  StudyTask task{configuration_id(scenario), experiment.get(), 128};
  task.steps = scenario.study.steps;
  const TempDirectory directory;
  const auto said_of = [&](const StudyStatistics& second, const std::string& evidence = "") -> std::string {
    fs::remove_all(directory.path());
    ResultStore store = ResultStore::open_to_write(directory.path(), "test");
    store.put_configuration(task.id, configuration_toml(scenario));
    store.put_chunk({task.id, 0, 64}, to_bytes(experiment->run_chunk(0, 64)));
    const auto beside = std::as_bytes(std::span(evidence));
    if (!evidence.empty()) store.put_companion({task.id, 64, 64}, beside, packed(beside));
    store.put_chunk({task.id, 64, 64}, to_bytes(second));
    EngineOptions options;
    options.store = &store;
    try {
      run_studies({&task, 1}, options);
    } catch (const StoreError& error) {
      return error.what();
    }
    return "taken";
  };
  const std::string whose = fmt::format("{}/results.sqlite: runs 64 to 127 of configuration {} are damaged (",
                                        directory.path().string(), task.id);
  const std::string another = whose + "they are those of another chunk): " + kDamageAdvice;
  const StudyStatistics right = experiment->run_chunk(64, 64);
  EXPECT_EQ(said_of(right), "taken");
  EXPECT_EQ(said_of(experiment->run_chunk(64, 32)), another) << "of fewer runs";
  StudyStatistics wrong = right;
  wrong.steps.pop_back();
  EXPECT_EQ(said_of(wrong), another) << "of fewer steps";
  for (const std::int64_t run : {63, 64, 127, 128}) {
    const std::string expected = run == 63 || run == 128 ? another : "taken";
    wrong = right;
    wrong.failures.push_back({run, 3, Outcome::diverged});
    EXPECT_EQ(said_of(wrong), expected) << run;
    wrong = right;
    wrong.not_converged.push_back({run, 3});
    EXPECT_EQ(said_of(wrong), expected) << run;
  }
  for (const bool fits : {true, false}) {
    task.found = [&](std::int64_t, std::int64_t, std::span<const std::byte>) { return fits; };
    EXPECT_EQ(
        said_of(right, "evidence"),
        fits ? "taken" : whose + "the evidence beside them is that of another chunk): " + kDamageAdvice);
  }
}

TEST(Engine, AStudyOutOfTimeReportsWhatIsThere) {
  const auto experiment = make_experiment(monobot(1000000000));
  const StudyTask task{.id = "a", .experiment = experiment.get(), .runs = 1000000000, .max_seconds = 0.05};
  EngineOptions options;
  options.threads = 2;
  const StudyResult result = run_studies({&task, 1}, options).front();
  EXPECT_TRUE(result.timed_out);
  EXPECT_TRUE(result.complete);
  EXPECT_GT(result.statistics.runs, 0);
  EXPECT_EQ(result.statistics, run(*experiment, result.statistics.runs, 2));
}

TEST(Engine, MoreRunsExtendAStudy) {
  const auto experiment = make_experiment(monobot(100));
  StudyStatistics first = run(*experiment, 64, 1);
  StudyStatistics second = experiment->run_chunk(64, 64);
  first.merge(second);
  EXPECT_EQ(first, run(*experiment, 128, 2));
}

/// Fails on purpose, to see that the engine passes it on.
class ThrowingExperiment final : public Experiment {
 public:
  ThrowingExperiment() : Experiment(RunLayout{}) {}
  StudyStatistics run_chunk(std::int64_t first_run, std::int64_t runs) const override {
    if (first_run > 0) throw std::runtime_error("on purpose");
    StudyStatistics s;
    s.runs = runs;
    return s;
  }
  Outcome visit(std::int64_t, const StepVisitor&) const override { return Outcome::ok; }
  RunTrace describe_world() const override { return {}; }
};

TEST(Engine, AnExceptionOfAnExperimentIsThrownOn) {
  const ThrowingExperiment experiment;
  const StudyTask task{"a", &experiment, 200};
  EXPECT_THROW(run_studies({&task, 1}, {}), std::runtime_error);
}

// ---- experiments ----

TEST(LinearExperiment, ARunAloneHasTheNumbersOfItsChunk) {
  const auto experiment = make_experiment(monobot(10));
  const StudyStatistics one = experiment->run_chunk(7, 1);
  const RunTrace trace = experiment->trace(7);
  ASSERT_EQ(trace.steps.size(), 21U);
  for (std::size_t k = 1; k <= 20; ++k) {
    // The moments of a chunk are kept in units of its own: the same bits of a run, rounded once more.
    const TraceStep& s = trace.steps[k];
    const auto expect_same = [](double chunk, double alone, Index dof) {
      EXPECT_NEAR(chunk, alone, 1e-14 * (std::abs(alone) + static_cast<double>(dof)));
    };
    expect_same(one.steps[k - 1][Quantity::nees].mean, s.nees, s.nees_dof);
    expect_same(one.steps[k - 1][Quantity::nis].mean, s.nis, s.nis_dof);
  }
}

TEST(PlanarExperiment, ARunAloneHasTheNumbersOfItsChunk) {
  const auto experiment = make_experiment(small_planar(10));
  const StudyStatistics one = experiment->run_chunk(7, 1);
  const RunTrace trace = experiment->trace(7);
  ASSERT_EQ(trace.steps.size(), 16U);
  for (std::size_t k = 1; k <= 15; ++k) {
    EXPECT_EQ(trace.steps[k].nees, one.steps[k - 1][Quantity::nees].mean);
    EXPECT_EQ(trace.steps[k].nees_dof, one.steps[k - 1].nees_dof);
  }
  EXPECT_EQ(trace.steps.back().landmarks.size(), 4U);
}

TEST(LinearExperiment, NeesOfATraceIsThatOfItsErrorAndCovariance) {
  const RunTrace trace = make_experiment(monobot(1))->trace(0);
  for (std::size_t k = 1; k < trace.steps.size(); ++k) {
    const TraceStep& s = trace.steps[k];
    const Vector e = s.truth - s.estimate;
    EXPECT_NEAR(s.nees / e.dot(s.P.llt().solve(e)), 1.0, 1e-9);
    EXPECT_NEAR(s.nis / s.innovation().dot(s.S().llt().solve(s.innovation())), 1.0, 1e-9);
  }
}

TEST(LinearExperiment, TwoFiltersInOneWorldMeetTheSameNoise) {
  Scenario inflated = monobot(1);
  inflated.filter.inflation = FilterInflation::map;
  const RunTrace a = make_experiment(monobot(1))->trace(3), b = make_experiment(inflated)->trace(3);
  for (std::size_t k = 0; k < a.steps.size(); ++k) EXPECT_EQ(a.steps[k].truth, b.steps[k].truth);
  EXPECT_NE(a.steps.back().estimate, b.steps.back().estimate);
}

/// A user's own filter: dead reckoning that never looks at a landmark.
class DeadReckoning {
 public:
  explicit DeadReckoning(double dt_s) { model_.dt_s = dt_s; }
  void reset(const Pose& pose, const Eigen::Matrix3d& P) {
    x_ = pose;
    P_ = P;
  }
  void predict(const Control& u) {
    const Motion m = model_.move(x_, u);
    x_ = m.pose;
    const Eigen::Matrix2d Q = Eigen::Vector2d(0.01, 0.0025).asDiagonal();
    P_ = m.F * P_ * m.F.transpose() + m.G * Q * m.G.transpose();
  }
  UpdateResult update(std::span<const Observation<PlanarModel>>) { return {.trace_prior = P_.trace()}; }
  const Vector& state() const { return x_; }
  const Matrix& covariance() const { return P_; }
  std::span<const int> landmarks() const { return {}; }
  const Vector& innovation() const { return none_; }
  const Matrix& innovation_covariance() const { return empty_; }
  const Matrix& gain() const { return empty_; }

 private:
  PlanarModel model_;
  Vector x_, none_;
  Matrix P_, empty_;
};

TEST(PlanarExperiment, RunsAFilterOfTheUsersOwn) {
  const Scenario scenario = small_planar(200);
  const PlanarExperiment<DeadReckoning> experiment(make_planar_world(scenario), PlanarNoise::of(scenario),
                                                   NoiseSource(1, noise_group(scenario)),
                                                   [&] { return DeadReckoning(scenario.world.dt); });
  const StudyStatistics s = run(experiment, 200, 2);
  EXPECT_EQ(s.steps.back().nees_dof, 600);
  EXPECT_EQ(s.steps.back().nis_dof, 0);
  // The first step is nearly linear: NEES of 200 runs is χ²(600)/200 = 3 ± 0.173; five standard errors.
  EXPECT_NEAR(s.steps.front()[Quantity::nees].mean, 3.0, 5.0 * std::sqrt(2.0 * 3.0 / 200.0));
}

/// Reports a failed factorisation at step 3 of every run.
class FailingFilter : public DeadReckoning {
 public:
  using DeadReckoning::DeadReckoning;
  void reset(const Pose& pose, const Eigen::Matrix3d& P) {
    DeadReckoning::reset(pose, P);
    step_ = 0;
  }
  UpdateResult update(std::span<const Observation<PlanarModel>>) { return {.ok = ++step_ != 3}; }

 private:
  int step_ = 0;
};

TEST(PlanarExperiment, FailedRunsAreCountedNamedAndEndThere) {
  const Scenario scenario = small_planar(70);
  const PlanarExperiment<FailingFilter> experiment(make_planar_world(scenario), PlanarNoise::of(scenario),
                                                   NoiseSource(1, 1), [] { return FailingFilter(0.25); });
  const StudyStatistics s = run(experiment, 70, 2);
  EXPECT_EQ(s.count(Outcome::not_positive_definite), 70);
  EXPECT_EQ(s.failures[69], (RunFailure{69, 3, Outcome::not_positive_definite}));
  EXPECT_EQ(s.steps[1][Quantity::nees].count, 70);
  EXPECT_EQ(s.steps[2][Quantity::nees].count, 0);
  const RunTrace trace = experiment.trace(69);
  EXPECT_EQ(trace.outcome, Outcome::not_positive_definite);
  EXPECT_EQ(trace.steps.size(), 4U);
}

}  // namespace
}  // namespace credence::internal
