#include "datasets/logs/run_fingerprints.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <random>
#include <string>

#include "datasets/data_error.h"
#include "datasets/logs/judge_logs.h"
#include "datasets/logs/run_name.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::filesystem::path kA = "a.csv", kB = "b.npz";

/// Rows of an error of two states and an innovation of one, of this seed; the first row is everybody's.
std::vector<Step> rows(unsigned seed, int count) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  std::vector<Step> steps;
  for (int k = 1; k <= count; ++k) {
    Step step{.step = k};
    step.error = Vector::NullaryExpr(2, [&] { return k == 1 ? 0.25 : normal(bits); });
    step.innovations.push_back({Vector::Constant(1, k == 1 ? 0.5 : normal(bits)), Matrix::Identity(1, 1)});
    steps.push_back(std::move(step));
  }
  return steps;
}

void add(RunFingerprints& prints, const std::vector<Step>& steps, std::optional<std::string> number) {
  prints.begin_run(std::move(number));
  for (const Step& step : steps) prints.add(step);
}

RunFingerprints of_file(const std::filesystem::path& file, const std::vector<std::vector<Step>>& runs) {
  RunFingerprints prints;
  prints.begin_file(file);
  RunNumber number;
  for (const std::vector<Step>& run : runs) add(prints, run, number.next());
  if (number.alone()) prints.name_by_file();
  return prints;
}

/// What is told of the runs of two files and not refused, one sentence a line.
std::string likenesses_of(const std::vector<std::vector<Step>>& a,
                          const std::vector<std::vector<Step>>& b = {}) {
  RunFingerprints prints = of_file(kA, a);
  prints.append(of_file(kB, b));
  std::string said;
  for (const RunFingerprints::Likeness& likeness : prints.likenesses())
    said += likeness.file.string() + ": " + likeness.sentence + "\n";
  said += prints.copies().says;
  return said;
}

/// To so many decimals.
std::vector<Step> rounded(std::vector<Step> steps, int decimals) {
  const double unit = std::pow(10.0, -decimals);
  for (Step& step : steps) {
    step.error = unit * (step.error / unit).array().round();
    for (Innovation& innovation : step.innovations)
      innovation.nu = unit * (innovation.nu / unit).array().round();
  }
  return steps;
}

std::vector<Step> joined(std::vector<Step> first, const std::vector<Step>& then) {
  first.insert(first.end(), then.begin(), then.end());
  return first;
}

/// One error of one number, e_k.
template <class Error>
std::vector<Step> scalar_rows(int count, Error e) {
  std::vector<Step> steps;
  for (int k = 1; k <= count; ++k) steps.push_back({.step = k, .error = Vector::Constant(1, e(k))});
  return steps;
}

/// What is said of the runs of two files; "" where they are distinct.
std::string complaint_of(const std::vector<std::vector<Step>>& a, const std::vector<std::vector<Step>>& b) {
  RunFingerprints prints = of_file(kA, a);
  prints.append(of_file(kB, b));
  try {
    prints.require_distinct();
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

TEST(RunFingerprints, KnowARunAgain) {
  EXPECT_THAT(complaint_of({rows(1, 40)}, {rows(1, 40)}),
              AllOf(HasSubstr("b.npz: it has"), HasSubstr("as a.csv:")));
  EXPECT_THAT(complaint_of({rows(1, 40), rows(2, 40)}, {rows(3, 40), rows(2, 40)}),
              AllOf(HasSubstr("b.npz: run 1 of it has"), HasSubstr("as run 1 of a.csv:")));
  EXPECT_THAT(complaint_of({rows(1, 40), rows(1, 40)}, {}), HasSubstr("a.csv: run 1 of it has"));
}

// Whichever of the two was cut off.
TEST(RunFingerprints, KnowACopyThatWasCutOff) {
  EXPECT_THAT(complaint_of({rows(1, 1000)}, {rows(1, 30)}), HasSubstr("first 16 rows"));
  EXPECT_THAT(complaint_of({rows(1, 30)}, {rows(1, 1000)}), HasSubstr("first 16 rows"));
  EXPECT_THAT(complaint_of({rows(2, 9), rows(1, 30)}, {rows(3, 7), rows(1, 1000)}),
              HasSubstr("as run 1 of a.csv"));
}

TEST(RunFingerprints, TheOrderOfTheColumnsDoesNotMatter) {
  std::vector<Step> turned = rows(1, 40);
  for (Step& step : turned) step.error.reverseInPlace();
  EXPECT_NE(complaint_of({rows(1, 40)}, {turned}), "");
}

// Runs that start the same, as worlds without process noise do until something is measured.
TEST(RunFingerprints, LeaveRunsAloneThatStartTheSame) {
  EXPECT_EQ(complaint_of({rows(1, 40)}, {rows(2, 40), rows(3, 40)}), "");
  std::vector<Step> branched = rows(1, 15), other = rows(2, 40);
  branched.insert(branched.end(), other.begin() + 15, other.end());
  EXPECT_EQ(complaint_of({rows(1, 40)}, {branched}), "");
}

// A few coarse numbers agree by chance, and zeros say nothing.
TEST(RunFingerprints, LeaveRunsAloneOfTooFewNumbers) {
  EXPECT_EQ(complaint_of({rows(1, 5)}, {rows(1, 5)}), "");  // 12 numbers in the first four rows
  std::vector<Step> silent = rows(1, 40);
  for (Step& step : silent) {
    step.error.setZero();
    step.innovations.clear();
  }
  EXPECT_EQ(complaint_of({silent}, {silent}), "");
}

/// Rows of `columns` numbers of ±1.
std::vector<Step> coarse_rows(unsigned seed, int count, Index columns) {
  std::mt19937_64 bits(seed);
  std::vector<Step> steps;
  for (int k = 1; k <= count; ++k) {
    Step step{.step = k};
    step.error = Vector::NullaryExpr(columns, [&] { return (bits() & 1U) == 0 ? 1.0 : -1.0; });
    steps.push_back(std::move(step));
  }
  return steps;
}

// Of 1000 runs of 16 numbers of two levels each some have the same, 2^-16 a pair; so have rows of 100, of
// which the order does not count. Of 1000 rows none have.
TEST(RunFingerprints, LeaveRunsAloneOfFewLevels) {
  const auto complaint = [](int count, Index columns) {
    std::vector<std::vector<Step>> runs;
    for (unsigned seed = 1; seed <= 1000; ++seed) runs.push_back(coarse_rows(seed, count, columns));
    return complaint_of(runs, {});
  };
  EXPECT_EQ(complaint(16, 1), "");
  EXPECT_EQ(complaint(2, 100), "");
  EXPECT_THAT(complaint_of({coarse_rows(1, 1000, 1)}, {coarse_rows(1, 1000, 1)}),
              HasSubstr("first 512 rows"));
}

// An error that goes up or down by a level at each row tells a bit a row, whatever levels it comes to.
TEST(RunFingerprints, LeaveRunsAloneThatGoUpAndDownByALevel) {
  std::vector<std::vector<Step>> runs;
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    double level = 20.0;
    std::vector<Step> walk = coarse_rows(seed, 16, 1);
    for (Step& step : walk) step.error[0] = 0.1 * (level += step.error[0]);
    runs.push_back(std::move(walk));
  }
  EXPECT_EQ(complaint_of(runs, {}), "");
}

// Each number stands for 20 rows, as of a slow sensor whose last value is repeated.
TEST(RunFingerprints, LeaveRunsAloneWhoseNumbersAreHeld) {
  std::vector<std::vector<Step>> runs;
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    std::vector<Step> held;
    for (const Step& step : coarse_rows(seed, 13, 1)) held.insert(held.end(), 20, step);
    runs.push_back(std::move(held));
  }
  EXPECT_EQ(complaint_of(runs, {}), "");
}

// Of many files, in parallel: the first one that was there before, whoever reads first.
TEST(RunFingerprints, OfManyFilesTheFirstCopyIsNamedForAnyNumberOfThreads) {
  constexpr unsigned kFiles = 300;
  std::vector<std::filesystem::path> files;
  for (unsigned i = 0; i < kFiles; ++i) files.emplace_back(std::to_string(i));
  const auto read = [](const std::filesystem::path& file, LogSink& sink) {
    const auto seed = static_cast<unsigned>(std::stoul(file.string()));
    RunLayout layout{.states = {"a", "b"}, .angles = {false, false}};
    layout.sensors.push_back({.name = "", .dim = 1, .piece = 1});
    sink.begin_run(layout);
    for (Step& step : rows(seed == 290 ? 7 : seed == 130 ? 100 : seed, 20)) {
      step.states = {0, 1};
      step.P = Matrix::Identity(2, 2);
      sink.add(step);
    }
  };
  for (const int threads : {1, 4}) {
    LogJudgeOptions options;
    options.threads = threads;
    try {
      judge_logs(files, read, options);
      ADD_FAILURE() << threads << " threads: the copies were counted";
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("130: it has"), HasSubstr("as 100:"))) << threads;
    }
  }
}

TEST(RunFingerprints, ALogThatWasAppendedToItselfIsTold) {
  const std::vector<Step> log = rows(1, 300);
  const std::string said = likenesses_of({joined(log, log)});
  EXPECT_THAT(said, AllOf(HasSubstr("a.csv: Rows 3"), HasSubstr("appended to itself")));
  EXPECT_THAT(likenesses_of({joined(log, std::vector<Step>(log.begin() + 100, log.begin() + 200))}),
              HasSubstr("appended to itself"));
  EXPECT_THAT(likenesses_of({joined(rounded(log, 1), rounded(log, 1))}), HasSubstr("appended to itself"));
  EXPECT_EQ(likenesses_of({joined(log, rows(2, 300))}), "");
}

TEST(RunFingerprints, RowsOfAnotherRunAreToldWhereverTheyAre) {
  const std::vector<Step> log = rows(1, 1000);
  EXPECT_THAT(likenesses_of({log}, {std::vector<Step>(log.begin() + 300, log.end())}),
              AllOf(HasSubstr("b.npz: Rows "), HasSubstr("of a.csv")));
  EXPECT_THAT(likenesses_of({std::vector<Step>(log.begin() + 300, log.end())}, {rows(2, 50), log}),
              HasSubstr("of run 1 of b.npz"));
}

TEST(RunFingerprints, ACopyThatWasRoundedIsTold) {
  for (const int decimals : {2, 4, 8}) {
    const std::string said = likenesses_of({rows(2, 60), rows(1, 60)}, {rounded(rows(1, 40), decimals)});
    EXPECT_THAT(said, AllOf(HasSubstr("b.npz has"), HasSubstr("errors of run 1 of a.csv"))) << decimals;
  }
  EXPECT_EQ(likenesses_of({rows(1, 60)}, {rounded(rows(2, 60), 1)}), "");
}

// Of twelve rows; of 400 pairs of such runs that are independent none is told.
TEST(RunFingerprints, ACopyOfAShortRunIsTold) {
  constexpr int kRows = 12;
  std::vector<std::vector<Step>> runs;
  for (unsigned seed = 1; seed <= 400; ++seed) runs.push_back(rows(seed, kRows));
  EXPECT_EQ(likenesses_of(runs), "");
  runs.push_back(rounded(rows(300, kRows), 3));
  EXPECT_THAT(likenesses_of(runs), HasSubstr("run 400 of a.csv has, in all rows that were looked at of the "
                                             "12 it shares, the errors of run 299"));
}

// Two levels agree by chance: of 500 such runs some in all rows that are kept of one component.
TEST(RunFingerprints, RunsOfTwoLevelsAreNoCopies) {
  std::mt19937_64 bits(9);
  std::vector<std::vector<Step>> runs;
  for (int i = 0; i < 500; ++i)
    runs.push_back(scalar_rows(100, [&](int) { return bits() % 2 == 0 ? 1.0 : -1.0; }));
  EXPECT_EQ(likenesses_of(runs), "");
}

// Zeros, a constant, an error that goes up and down by one level, two levels by chance, noise of 20 levels,
// and runs that start alike: of none of them it is told that it is there twice.
TEST(RunFingerprints, WhatIsAlikeByItsNatureIsNotTold) {
  std::mt19937_64 bits(7);
  const auto level = [&](int levels) { return static_cast<double>(bits() % static_cast<unsigned>(levels)); };
  double walk = 0.0;
  const std::vector<std::vector<Step>> kinds[] = {
      {scalar_rows(500, [](int) { return 0.0; }), scalar_rows(500, [](int) { return 0.0; })},
      {scalar_rows(500, [](int) { return 0.5; }), scalar_rows(500, [](int) { return 0.5; })},
      {scalar_rows(500, [](int k) { return k % 2; }), scalar_rows(500, [](int k) { return k % 2; })},
      {scalar_rows(2000, [&](int) { return 1.0 + level(2); }),
       scalar_rows(2000, [&](int) { return 1.0 + level(2); })},
      {scalar_rows(2000, [&](int) { return walk += level(2) - 0.5; }),
       scalar_rows(500, [&](int) { return walk += level(2) - 0.5; })},
      {scalar_rows(20000, [&](int) { return 1.0 + level(20); }),
       scalar_rows(20000, [&](int) { return 1.0 + level(20); })},
      {joined(rows(1, 30), rows(2, 100)), joined(rows(1, 30), rows(3, 100))}};
  int kind = 0;
  for (const auto& runs : kinds) {
    EXPECT_EQ(likenesses_of({runs[0]}, {runs[1]}), "") << kind;
    ++kind;
  }
}

// e_k = e₀ cos 0.7 k: of 200 runs some agree to a fiftieth in all that they hold.
TEST(RunFingerprints, RunsOfOneRandomNumberAreNoCopies) {
  std::mt19937_64 bits(8);
  std::normal_distribution<double> normal;
  std::vector<std::vector<Step>> runs;
  for (int i = 0; i < 200; ++i) {
    const double start = normal(bits);
    runs.push_back(scalar_rows(400, [&](int k) { return start * std::cos(0.7 * k); }));
  }
  EXPECT_EQ(likenesses_of(runs), "");
  std::vector<std::vector<Step>> copied = {rows(1, 60), rows(2, 60), rows(3, 60), rounded(rows(2, 60), 3)};
  EXPECT_THAT(likenesses_of(copied), HasSubstr("run 3 of a.csv has"));
}

}  // namespace
}  // namespace credence::internal
