#include "datasets/logs/judge_logs.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <map>
#include <random>
#include <thread>

#include "analysis/calibration/calibration.h"
#include "analysis/evidence/sums/evidence_bytes.h"
#include "analysis/evidence/verdicts/judgement.h"
#include "core/stop_point.h"
#include "datasets/logs/filter_log.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

struct SensorOfFile {
  Index piece = 1, pieces = 1;
};

/// What a file is made of: its name is the seed of its errors.
struct FileOfRuns {
  std::vector<std::string> states;
  std::map<std::string, SensorOfFile> sensors{};
};

using Files = std::map<std::filesystem::path, FileOfRuns>;

RunLayout layout_of_file(const FileOfRuns& file) {
  RunLayout layout;
  layout.states = file.states;
  layout.angles.assign(file.states.size(), false);
  for (const auto& [name, sensor] : file.sensors) {
    layout.sensors.push_back({.name = name, .dim = sensor.piece * sensor.pieces, .piece = sensor.piece});
  }
  add_named_blocks(layout);
  return layout;
}

/// Eight consistent runs of 40 steps in each file.
void play_file(const std::filesystem::path& path, const FileOfRuns& file, LogSink& sink) {
  std::mt19937_64 bits(std::stoul(path.string()));
  std::normal_distribution<double> normal;
  const auto draw = [&](Index n) { return Vector(Vector::NullaryExpr(n, [&] { return normal(bits); })); };
  const RunLayout layout = layout_of_file(file);
  const Index n = std::ssize(file.states);
  for (int run = 0; run < 8; ++run) {
    sink.begin_run(layout);
    for (std::int64_t k = 1; k <= 40; ++k) {
      Step step{.step = k, .states = {}, .error = 0.1 * draw(n), .P = 0.01 * Matrix::Identity(n, n)};
      for (Index i = 0; i < n; ++i) step.states.push_back(i);
      for (const Sensor& sensor : layout.sensors) {
        step.innovations.push_back({draw(sensor.dim), Matrix::Identity(sensor.dim, sensor.dim)});
      }
      sink.add(step);
    }
  }
}

LogJudgeResult judge_files(const Files& files) {
  std::vector<std::filesystem::path> paths;
  for (const auto& [path, unused] : files) paths.push_back(path);
  return judge_logs(
      paths, [&](const std::filesystem::path& path, LogSink& sink) { play_file(path, files.at(path), sink); },
      {});
}

const std::vector<std::string> kThree = {"pose.x", "pose.y", "bias"}, kTwo = {"pose.x", "bias"},
                               kOthers = {"pose.x", "pose.y", "clock"};

/// Runs with these numbers in their file.
LogJudgeResult judge_numbered(const std::string& file, const std::vector<int>& numbers, int threads) {
  const std::vector<std::filesystem::path> paths = {file};
  const auto read = [&](const std::filesystem::path& /*path*/, LogSink& sink) {
    std::mt19937_64 bits(3);
    std::normal_distribution<double> normal;
    for (const int number : numbers) {
      sink.run_number(fmt::to_string(number));
      sink.begin_run(layout_of_file({kTwo}));
      for (std::int64_t k = 1; k <= 40; ++k) {
        const Vector error = Vector::NullaryExpr(2, [&] { return normal(bits); });
        sink.add({.step = k, .states = {0, 1}, .error = error, .P = Matrix::Identity(2, 2)});
      }
    }
  };
  return judge_logs(paths, read, {.threads = threads});
}

// As in a CSV with a column `run`, and in arrays of one run, which have none.
TEST(JudgeLogs, ARunThatIsAloneInItsFileIsNamedByIt) {
  for (const int threads : {1, 2}) {
    const LogJudgeResult alone = judge_numbered("logs/dv.csv", {13}, threads);
    EXPECT_EQ(alone.run_names, std::vector<std::string>{"dv"});
    EXPECT_EQ(alone.calibration.runs.at(0).name, "dv");
    const LogJudgeResult two = judge_numbered("logs/dv.csv", {13, 14}, threads);
    EXPECT_EQ(two.run_names, (std::vector<std::string>{"run 13 of dv", "run 14 of dv"}));
    EXPECT_EQ(two.calibration.runs.at(1).name, "run 14 of dv");
  }
  EXPECT_EQ(judge_files({{"1", {kTwo}}}).run_names.front(), "run 0 of 1") << "told no number";
}

// Beyond the runs and states that are calibrated, and the runs of which the course in time is kept.
TEST(JudgeLogs, EveryRunHasItsName) {
  Files files;
  for (int i = 0; i < 600; ++i) files[std::to_string(i)] = {kTwo};
  const LogJudgeResult result = judge_files(files);
  ASSERT_EQ(result.run_names.size(), 4800U);
  EXPECT_EQ(result.run_names.back(), "run 7 of 99");
  EXPECT_EQ(result.evidence.whole_runs.courses(2.0).size(), 4800U);
}

// Sums over some states do not add up with those over others: the most states count, wherever their file
// stands.
TEST(JudgeLogs, OfFilesWithOtherStatesThoseWithMostAreCalibrated) {
  for (const auto& [first, second] : {std::pair(kThree, kTwo), std::pair(kTwo, kThree)}) {
    LogJudgeResult result = judge_files({{"1", {first}}, {"2", {second}}, {"3", {first}}});
    EXPECT_EQ(result.files, 3);
    EXPECT_EQ(result.evidence.study.runs, 24);
    EXPECT_EQ(result.calibration.layout.states, kThree);
    const std::size_t runs = first == kThree ? 16U : 8U;
    ASSERT_EQ(result.calibration.runs.size(), runs);
    for (const CalibrationRun& run : result.calibration.runs) EXPECT_EQ(run.whole.marginal.size(), 2U);
    EXPECT_EQ(result.evidence.law.second_moments.dim(), 3);
    EXPECT_EQ(result.evidence.law.second_moments.runs(), static_cast<std::int64_t>(runs));
    EXPECT_EQ(result.evidence.law.whitened.at(1).count, static_cast<std::int64_t>(runs));
  }
}

// Twenty files of one run of 15 rows, too few for each to tell that standard deviations stand for P.
TEST(JudgeLogs, AMistakeOfUnitsIsSeenInTheFilesTogether) {
  std::vector<std::filesystem::path> paths;
  for (int i = 0; i < 20; ++i) paths.emplace_back(std::to_string(i));
  const auto remarks_of = [&](bool deviations) {
    const auto read = [deviations](const std::filesystem::path& path, LogSink& sink) {
      std::mt19937_64 bits(std::stoul(path.string()));
      std::normal_distribution<double> normal(0.0, 0.1);
      sink.begin_run(layout_of_file({kThree}));
      for (std::int64_t k = 1; k <= 15; ++k) {
        Step step{
            .step = k, .states = {0, 1, 2}, .error = Vector::NullaryExpr(3, [&] { return normal(bits); })};
        step.P = (deviations ? 0.1 : 0.01) * Matrix::Identity(3, 3);
        sink.add(step);
      }
    };
    return judge_logs(paths, read, {}).remarks;
  };
  EXPECT_TRUE(remarks_of(false).empty());
  const std::vector<LogRemark> told = remarks_of(true);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].sentence.find("It would fit if P holds standard deviations, not variances"),
            std::string::npos)
      << told[0].sentence;
  EXPECT_EQ(told[0].kind, LogRemark::Kind::misfit);
}

TEST(JudgeLogs, FilesWithOtherStatesAreToldOfOnce) {
  const auto remarks_of = [](const Files& files) {
    std::vector<std::string> sentences;
    for (const LogRemark& remark : judge_files(files).remarks) sentences.push_back(remark.sentence);
    return sentences;
  };
  const std::vector<std::string> reordered = {"bias", "pose.y", "pose.x"};
  EXPECT_TRUE(remarks_of({{"1", {kThree}}, {"2", {reordered}}}).empty());
  EXPECT_TRUE(
      remarks_of({{"1", {{"vehicle.x", "landmark1.x"}}}, {"2", {{"vehicle.x", "landmark2.x"}}}}).empty());
  const std::vector<std::string> told =
      remarks_of({{"1", {kThree}}, {"2", {kThree}}, {"3", {kOthers}}, {"4", {kTwo}}});
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0],
            "3 has clock and lacks bias, compared with 1: files of one filter have the same states, and each "
            "state is judged by those that have it.");
  EXPECT_EQ(remarks_of({{"1", {kThree}}, {"2", {kTwo}}}).at(0).substr(0, 36),
            "2 lacks pose.y, compared with 1: fil");
  EXPECT_EQ(remarks_of({{"1", {kTwo}}, {"2", {{"pose.x", "bias", "a", "b", "c", "d"}}}}).at(0).substr(0, 29),
            "2 has a, b, c and 1 more, com");
}

TEST(JudgeLogs, OfAsManyOtherStatesTheFirstAreCalibrated) {
  const LogJudgeResult result = judge_files({{"1", {kThree}}, {"2", {kOthers}}});
  EXPECT_EQ(result.calibration.layout.states, kThree);
  EXPECT_EQ(result.calibration.runs.size(), 8U);
}

// The state is averaged up to 24 of them, beyond that its first block: the names stay with the numbers.
TEST(JudgeLogs, SecondMomentsAreOfTheStatesTheyName) {
  std::vector<std::string> many = {"pose.x", "pose.y"};
  for (int i = 0; i < 23; ++i) many.push_back(fmt::format("other{}", i));
  const Files files[] = {{{"1", {many}}, {"2", {kThree}}}, {{"1", {kThree}}, {"2", {many}}}};
  for (const Files& both : files) {
    const LawSums law = judge_files(both).evidence.law;
    EXPECT_EQ(law.second_moments.dim(), 3);  // kThree as a whole, and not the pose of two
    EXPECT_EQ(law.averaged, "");
  }
}

/// A run of 2500 rows, some of which are rejected and some of which have a P without a factor; slowly: those
/// who take its rows wait for them.
void play_long_file(const std::filesystem::path& path, bool slowly, LogSink& sink) {
  std::mt19937_64 bits(std::stoul(path.string()));
  std::normal_distribution<double> normal;
  const RunLayout layout = layout_of_file({kThree, {{"a", {2, 1}}}});
  sink.begin_run(layout);
  for (std::int64_t k = 1; k <= 2500; ++k) {
    Step step{.step = k,
              .line = k + 1,
              .states = {0, 1, 2},
              .error = Vector(3),
              .P = 0.01 * Matrix::Identity(3, 3)};
    for (double& error : step.error) error = 0.1 * normal(bits);
    if (k % 37 == 0) step.P(1, 1) = -1.0;
    if (k % 50 == 0) step.error[2] = step.P(2, 2) = 0.0;
    if (k % 43 == 0) step.P.topLeftCorner(2, 2) << 1.0, 1.0 - 1e-13, 1.0 - 1e-13, 1.0;  // only just
    if (k % 41 == 0) step.problem = "a covariance is not symmetric";
    step.innovations.push_back(
        {Vector::NullaryExpr(2, [&] { return normal(bits); }), Matrix::Identity(2, 2)});
    sink.travelled(0.5 * static_cast<double>(k));
    sink.add(step);
    if (slowly && k % 500 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

TEST(JudgeLogs, TheSameBitsWhicheverThreadNormalisesTheRows) {
  const std::vector<std::filesystem::path> paths = {"1", "2", "3", "4"};
  const auto judged = [&](int threads, bool slowly) {
    return judge_logs(
        paths, [=](const std::filesystem::path& path, LogSink& sink) { play_long_file(path, slowly, sink); },
        {.threads = threads});
  };
  const LogJudgeResult alone = judged(1, false);
  EXPECT_EQ(alone.evidence.rows, 10'000);
  EXPECT_EQ(alone.evidence.rejected.size(), 2U);
  for (const bool slowly : {false, true}) {
    const LogJudgeResult ahead = judged(4, slowly);
    EXPECT_EQ(to_bytes(ahead.evidence), to_bytes(alone.evidence));
    ASSERT_EQ(ahead.calibration.runs.size(), 4U);
    for (std::size_t i = 0; i < 4; ++i) {
      const CalibrationRun &one = ahead.calibration.runs[i], &other = alone.calibration.runs[i];
      EXPECT_EQ(one.whole.rows, other.whole.rows);
      EXPECT_EQ(one.whole.nees, other.whole.nees);
      EXPECT_EQ(one.whole.pairs, other.whole.pairs);
      EXPECT_EQ(one.coverage_factor, other.coverage_factor);
      EXPECT_EQ(one.distance.bins().size(), other.distance.bins().size());
    }
  }
}

// Of sensors of one name with other observations the sum of all components is followed, and two sensors are
// compared where they are what they were before.
/// Files of one state that are interrupted once so many rows of one of them are told.
LogJudgeResult judge_interrupted(int files, int in_file, int rows, int threads) {
  std::atomic<bool> stop = false;
  std::vector<std::filesystem::path> paths;
  for (int i = 0; i < files; ++i) paths.emplace_back(fmt::format("{}.csv", i));
  const auto read = [&](const std::filesystem::path& path, LogSink& sink) {
    const int file = std::stoi(path.string());
    std::mt19937_64 bits(static_cast<unsigned>(file));
    std::normal_distribution<double> normal;
    if (file == in_file && rows == 0) stop = true;
    stop_point();
    sink.begin_run({.states = {"x"}, .angles = {false}});
    for (std::int64_t k = 1; k <= 400; ++k) {
      sink.add({.step = k, .states = {0}, .error = Vector{{normal(bits)}}, .P = Matrix::Ones(1, 1)});
      if (file == in_file && k == rows) stop = true;
    }
  };
  return judge_logs(paths, read, {.threads = threads, .stop = &stop});
}

// Alone, while it is read ahead and while it is not; after others; and before its first row.
TEST(JudgeLogs, WhatWasReadBeforeAnInterruptionIsJudged) {
  for (const int threads : {1, 4}) {
    const LogJudgeResult alone = judge_interrupted(1, 0, 150, threads);
    EXPECT_FALSE(alone.complete);
    EXPECT_EQ(alone.evidence.rows, 150);
    EXPECT_EQ(alone.evidence.study.nees_of_runs.moments.count, 1);
    EXPECT_EQ(alone.run_names, std::vector<std::string>{"0"});
    ASSERT_EQ(alone.remarks.size(), 1U);
    EXPECT_EQ(alone.remarks[0].sentence, "interrupted: its first 150 rows are judged");
    const LogJudgeResult third = judge_interrupted(5, 2, 7, threads);
    EXPECT_FALSE(third.complete);
    EXPECT_EQ(third.evidence.rows, 807);
    EXPECT_EQ(third.files, 3);
    const LogJudgeResult before = judge_interrupted(5, 2, 0, threads);
    EXPECT_FALSE(before.complete);
    EXPECT_EQ(before.evidence.rows, 800);
    EXPECT_EQ(before.files, 2);
    EXPECT_TRUE(before.remarks.empty());
    EXPECT_EQ(judge_interrupted(1, 0, 0, threads).evidence.rows, 0);
  }
}

TEST(JudgeLogs, SensorsMayMeasureOtherThingsInOtherFiles) {
  const FileOfRuns one{kTwo, {{"a", {2, 2}}, {"b", {3, 1}}}}, other{kTwo, {{"a", {3, 2}}, {"b", {1, 1}}}};
  LogJudgeResult result = judge_files({{"1", one}, {"2", other}, {"3", one}});
  ASSERT_EQ(result.evidence.sensors.size(), 2U);
  EXPECT_TRUE(result.evidence.sensors[0].varies);
  EXPECT_TRUE(result.evidence.sensors[1].varies);
  EXPECT_EQ(result.evidence.sensors[0].sensor.dim, 4);  // of the first file; both are in by_dimension
  EXPECT_EQ(result.evidence.sensors[0].by_dimension.at(4).value.count, 640);
  EXPECT_EQ(result.evidence.sensors[0].by_dimension.at(6).value.count, 320);
  ASSERT_EQ(result.evidence.sensor_pairs.size(), 1U);
  EXPECT_EQ(result.evidence.sensor_pairs[0].both.count, 640);
  EXPECT_EQ(result.evidence.sensor_pairs[0].both.mean.size(), 7);
}

// Nine states drawn at random, and sensors: any mixture is judged, and a consistent filter is rarely accused:
// each of 40 mixtures with probability 5 % at most, so that nine are expected once in 50,000.
TEST(JudgeLogs, AnyMixtureOfFilesIsJudged) {
  std::mt19937_64 bits(7);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(bits() % n); };
  int accused = 0;
  for (int mixture = 0; mixture < 40; ++mixture) {
    Files files;
    for (int i = 0; i < 5; ++i) {
      FileOfRuns file;
      for (const char* name : {"pose.x", "pose.y", "pose.z", "map.a", "map.b", "bias", "d", "e", "f"}) {
        if (file.states.empty() || below(2) == 0) file.states.emplace_back(name);
      }
      for (std::size_t s = below(3); s > 0; --s) {
        file.sensors[fmt::format("sensor{}", s)] = {1 + static_cast<Index>(below(3)),
                                                    1 + static_cast<Index>(below(3))};
      }
      files[std::to_string(100 * mixture + i)] = file;
    }
    LogJudgeResult result = judge_files(files);
    const Calibration calibration = judge_calibration(result.calibration, 0.95);
    EXPECT_TRUE(std::isfinite(calibration.whole.factor.mean));
    accused += is_inconsistent(judge(result.evidence).word.verdict) ? 1 : 0;
  }
  EXPECT_LT(accused, 9);
}

/// Runs of a vehicle and a landmark in the plane as CSV, their columns in this order.
std::string planar_log(const std::vector<std::string>& states) {
  const std::map<std::string, double> starts = {{"vehicle.x", 1.0},
                                                {"vehicle.y", 2.0},
                                                {"vehicle.heading", 0.5},
                                                {"landmark1.x", 5.0},
                                                {"landmark1.y", 7.0}};
  std::string text = "run,step", rows;
  for (const std::string& state : states) {
    text += fmt::format(",estimate.{}{},truth.{}", state, state == "vehicle.heading" ? ":angle" : "", state);
  }
  for (std::size_t i = 1; i <= states.size(); ++i) {
    for (std::size_t j = i; j <= states.size(); ++j) text += fmt::format(",P.{}.{}", i, j);
  }
  std::mt19937_64 bits(3);
  std::normal_distribution<double> normal;
  for (int row = 0; row < 400; ++row) {
    const int run = row / 40, step = row % 40 + 1;
    std::map<std::string, double> error;
    for (const auto& [state, unused] : starts) error[state] = 0.1 * normal(bits);
    rows += fmt::format("{},{}", run, step);
    for (const std::string& state : states) {
      const double truth = starts.at(state) + (state.starts_with("vehicle") ? 0.05 * step : 0.0);
      rows += fmt::format(",{},{}", truth + error.at(state), truth);
    }
    for (std::size_t i = 0; i < states.size(); ++i) {
      for (std::size_t j = i; j < states.size(); ++j) rows += i == j ? ",0.01" : ",0";
    }
    rows += "\n";
  }
  return text + "\n" + rows;
}

// The order of the columns is the writer's affair: the pose is known, and what is concluded from it is the
// same.
TEST(JudgeLogs, APoseIsJudgedInWhateverOrderItsStatesStand) {
  const TemporaryFolder folder;
  const auto judged = [&](const std::vector<std::string>& states) {
    const std::vector<std::filesystem::path> files = {folder.write("log.csv", planar_log(states))};
    return judge_logs(
               files,
               [](const std::filesystem::path& file, LogSink& sink) { own_format().read(file, {}, sink); },
               {})
        .evidence;
  };
  const Evidence usual = judged({"vehicle.x", "vehicle.y", "vehicle.heading", "landmark1.x", "landmark1.y"});
  const Evidence turned = judged({"landmark1.y", "vehicle.heading", "vehicle.y", "landmark1.x", "vehicle.x"});
  for (const char* block : {"vehicle", "position", "heading", "landmark1", "all landmarks"}) {
    const auto of = [&](const Evidence& e) { return std::ranges::find(e.blocks, block, &BlockSums::name); };
    ASSERT_NE(of(turned), turned.blocks.end()) << block;
    EXPECT_EQ(of(turned)->part, of(usual)->part) << block;
    EXPECT_EQ(of(turned)->squared_error.count, of(usual)->squared_error.count) << block;
    EXPECT_NEAR(of(turned)->squared_error.mean, of(usual)->squared_error.mean, 1e-12) << block;
  }
  ASSERT_GT(usual.lateness.runs.count, 0);
  ASSERT_EQ(turned.lateness.runs.count, usual.lateness.runs.count);
  EXPECT_LT((turned.lateness.runs.mean - usual.lateness.runs.mean).norm(),
            1e-9 * usual.lateness.runs.mean.norm());
}

}  // namespace
}  // namespace credence::internal
