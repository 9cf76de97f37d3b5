#include "reports/document/logs/check_logs.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/data_error.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A log whose error has `scale` times the variance that it claims.
std::string log_text(int rows, double scale, unsigned seed) {
  std::mt19937 bits(seed);
  std::normal_distribution<double> normal;
  std::string text = "step,truth.x,estimate.x,P.1.1\n";
  for (int k = 1; k <= rows; ++k) {
    text += std::to_string(k) + ",0," + std::to_string(std::sqrt(scale) * normal(bits)) + ",1\n";
  }
  return text;
}

class CheckLogs : public ::testing::Test {
 protected:
  CheckLogs() {
    for (const char* name : {"good", "bad"}) std::filesystem::create_directory(folder_ / name);
    for (unsigned seed = 1; seed <= 12; ++seed) {
      folder_.write("good/run" + std::to_string(seed) + ".csv", log_text(50, 1.0, seed));
      folder_.write("bad/run" + std::to_string(seed) + ".csv", log_text(50, 4.0, seed));
    }
  }
  TemporaryFolder folder_;
};

TEST_F(CheckLogs, JudgesAFolderAndItsFilesAlike) {
  const std::string good = (folder_ / "good").string();
  const JudgedFilter judged = check_logs({&good, 1});
  EXPECT_EQ(judged.verdict(), Verdict::consistent) << judged.text();
  std::vector<std::string> files;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    files.push_back((folder_ / ("good/run" + std::to_string(seed) + ".csv")).string());
  }
  std::ranges::sort(files);
  EXPECT_EQ(check_logs(files, {.name = "good", .threads = 2}).json(), judged.json());
}

TEST_F(CheckLogs, TellsTheFactorOfAWrongOne) {
  const std::string bad = (folder_ / "bad").string();
  const JudgedFilter judged = check_logs({&bad, 1}, {.name = "mine"});
  EXPECT_EQ(judged.verdict(), Verdict::optimistic);
  EXPECT_LT(judged.factor().lower, 4.0);
  EXPECT_GT(judged.factor().upper, 4.0);
  EXPECT_THAT(judged.text(), HasSubstr("600 rows of 12 runs"));
  judged.write_report(folder_ / "out");
  EXPECT_THAT(folder_.read("out/index.html"), HasSubstr("mine"));
}

TEST_F(CheckLogs, AnRThatIsLargerThanSIsTold) {
  const auto said_with = [&](const char* R) {
    std::mt19937 bits(1);
    std::normal_distribution<double> normal;
    std::string text = "step,truth.x,estimate.x,P.1.1,innovation.1,S.1.1,R.1.1\n";
    for (int k = 1; k <= 100; ++k)
      text += fmt::format("{},0,{},1,{},2,{}\n", k, normal(bits), std::sqrt(2.0) * normal(bits), R);
    folder_.write("noise.csv", text);
    const std::string file = (folder_ / "noise.csv").string();
    return check_logs({&file, 1}).text();
  };
  EXPECT_THAT(said_with("5"), HasSubstr("R is larger than S, by tr(S⁻¹ R)/m = 2.50"));
  EXPECT_THAT(said_with("2"), Not(HasSubstr("larger than S")));
}

// Half of each error stays over its run, which P rightly holds. Run by run two thirds look as if P were too
// large, and in many of them it would fit as a standard deviation.
TEST_F(CheckLogs, ErrorsThatStayInARunAreNoMistakeOfUnits) {
  std::filesystem::create_directory(folder_ / "considered");
  std::mt19937 bits(5);
  std::normal_distribution<double> normal(0.0, 0.5);
  for (int run = 0; run < 25; ++run) {
    std::string text = "step,error.x,P.1.1\n";
    const double bias = normal(bits);
    for (int k = 1; k <= 300; ++k) text += fmt::format("{},{},0.5\n", k, bias + normal(bits));
    folder_.write(fmt::format("considered/run{}.csv", run), text);
  }
  const std::string logs = (folder_ / "considered").string();
  const JudgedFilter judged = check_logs({&logs, 1});
  EXPECT_EQ(judged.verdict(), Verdict::consistent) << judged.text();
  EXPECT_THAT(judged.text(), Not(HasSubstr("does not fit as it is read")));
  EXPECT_LT(judged.factor().lower, 1.0);
  EXPECT_GT(judged.factor().upper, 1.0);
}

// Of standard deviations σ² taken for variances: a wrong scale is what is seen, and not what is wrong.
TEST_F(CheckLogs, AMistakeThatIsFoundIsNotCalledAWrongScaleBesides) {
  const auto of = [&](double written) {
    std::mt19937 bits(5);
    std::normal_distribution<double> normal;
    std::string text = "step,truth.x,estimate.x,P.1.1\n";
    for (int k = 1; k <= 600; ++k) {
      const double sigma = k % 2 == 0 ? 0.01 : 0.03;
      text += std::to_string(k) + ",0," + std::to_string(sigma * normal(bits)) + "," +
              std::to_string(written > 0.0 ? written * sigma * sigma : sigma) + "\n";
    }
    folder_.write("mistake.csv", text);
    const std::string file = (folder_ / "mistake.csv").string();
    return check_logs({&file, 1});
  };
  const auto names_scale = [](const JudgedFilter& judged) {
    return std::ranges::any_of(
        judged.causes(), [](const NamedCause& cause) { return cause.name == "the scale of the covariance"; });
  };
  const JudgedFilter deviations = of(0.0), scaled = of(0.3);
  EXPECT_THAT(deviations.text(), HasSubstr("P holds standard deviations"));
  EXPECT_EQ(deviations.verdict(), Verdict::pessimistic);
  EXPECT_FALSE(names_scale(deviations)) << deviations.text();
  EXPECT_TRUE(names_scale(scaled)) << scaled.text();
}

// Degrees make the errors of a nonlinear filter too large for P, and its innovations stay what they were.
TEST_F(CheckLogs, AMistakeThatIsFoundIsNotCalledALinearisationBesides) {
  const auto of = [&](double unit) {
    std::mt19937 bits(5);
    std::normal_distribution<double> normal;
    std::string text =
        "step,truth.x,truth.heading,estimate.x,estimate.heading:angle,P.1.1,P.1.2,P.2.2,innovation.1,S.1.1,"
        "nonlinear\n";
    for (int k = 1; k <= 600; ++k) {
      const double sigma = k % 2 == 0 ? 0.002 : 0.004, x = normal(bits),
                   heading = unit * sigma * normal(bits);
      text += std::to_string(k) + ",0,0," + std::to_string(x) + "," + std::to_string(heading) + ",1,0," +
              std::to_string(sigma * sigma) + "," + std::to_string(normal(bits)) + ",1,1\n";
    }
    folder_.write("degrees.csv", text);
    const std::string file = (folder_ / "degrees.csv").string();
    return check_logs({&file, 1});
  };
  const JudgedFilter degrees = of(57.29578), larger = of(5.0);
  EXPECT_THAT(degrees.text(), HasSubstr("degrees"));
  EXPECT_EQ(degrees.verdict(), Verdict::optimistic);
  EXPECT_TRUE(degrees.causes().empty()) << degrees.text();
  EXPECT_FALSE(larger.causes().empty()) << larger.text();
}

// Two drives of one set-up, stamped 0.1 s late.
TEST_F(CheckLogs, FilesOfPosesHaveOneTimeOffsetOrEachItsOwn) {
  const auto row = [](double t, double at, double x, double y) {
    return fmt::format("{} {} {} 0.5 0 0 0 1", t, 4.0 * std::cos(0.7 * at) + x, 3.0 * std::sin(0.7 * at) + y);
  };
  std::string truth;
  for (int i = 0; i < 320; ++i) truth += row(0.05 * i, 0.05 * i, 0.0, 0.0) + "\n";
  folder_.write("truth.txt", truth);
  std::vector<std::string> files;
  for (unsigned seed : {1U, 2U}) {
    std::mt19937 bits(seed);
    std::normal_distribution<double> normal(0.0, 0.02);
    std::string text;
    for (int i = 0; i < 300; ++i) {
      text += row(0.05 * i, 0.05 * i + 0.1, normal(bits), normal(bits));
      for (int k = 0; k < 6; ++k) {
        for (int j = k; j < 6; ++j) text += k == j ? " 4e-4" : " 0";
      }
      text += "\n";
    }
    folder_.write(fmt::format("drive{}.tum", seed), text);
    files.push_back((folder_ / fmt::format("drive{}.tum", seed)).string());
  }
  CheckOptions options{.name = "drives", .truths = {(folder_ / "truth.txt").string()}, .threads = 1};
  options.reading.matching.max_time_difference_s = 0.06;
  options.reading.matching.find_time_offset = TimeOffsetSearch::together;
  const std::string together = check_logs(files, options).json();
  EXPECT_THAT(together, HasSubstr("One time offset of all 2 files together"));
  options.threads = 3;
  EXPECT_EQ(check_logs(files, options).json(), together);
  options.reading.matching.find_time_offset = TimeOffsetSearch::each;
  EXPECT_THAT(
      check_logs(files, options).json(),
      ::testing::AllOf(HasSubstr("drive1.tum: The time offset was estimated"),
                       Not(HasSubstr("drive2.tum: The time offset was estimated")),
                       HasSubstr("(1 more file has other numbers.)"), Not(HasSubstr("files together"))));
}

TEST_F(CheckLogs, FactorsOfRowsWithAllStatesSaySo) {
  std::mt19937 bits(9);
  std::normal_distribution<double> normal;
  std::string text = "run,step,error.a.x,error.b.x,P.1.1,P.1.2,P.2.2\n";
  for (int run = 0; run < 12; ++run) {
    for (int k = 1; k <= 50; ++k) {
      text += fmt::format("{},{},{},", run, k, normal(bits));
      text += k > 20 ? fmt::format("{},1,0,1\n", normal(bits)) : ",1,,\n";
    }
  }
  folder_.write("late.csv", text);
  const std::string file = (folder_ / "late.csv").string();
  EXPECT_THAT(check_logs({&file, 1}).text(),
              HasSubstr("These factors are of the 360 rows that have all states, of 600."));
  const std::string good = (folder_ / "good").string();
  EXPECT_THAT(check_logs({&good, 1}).text(), Not(HasSubstr("These factors")));
}

TEST_F(CheckLogs, StoppedBeforeTheFirstRowsIsAnError) {
  static constexpr std::atomic<bool> kStop{true};
  const std::string good = (folder_ / "good").string();
  EXPECT_THROW(check_logs({&good, 1}, {.stop = &kStop}), std::runtime_error);
}

TEST_F(CheckLogs, TellsHowManyBytesAreRead) {
  const std::string good = (folder_ / "good").string();
  std::int64_t read = 0, all = 0;
  check_logs({&good, 1}, {.threads = 1, .progress = [&](std::int64_t done, std::int64_t total) {
                            EXPECT_GE(done, read);
                            read = done;
                            all = total;
                          }});
  EXPECT_GT(all, 0);
  EXPECT_EQ(read, all);
}

TEST_F(CheckLogs, RefusesWhatDoesNotFit) {
  const std::string good = (folder_ / "good").string(), absent = (folder_ / "absent.csv").string();
  EXPECT_THROW(check_logs({&absent, 1}), DataError);
  EXPECT_THROW(check_logs({&good, 1}, {.format = "excel"}), std::invalid_argument);
  EXPECT_THROW(check_logs({&good, 1}, {.truths = {good}}), std::invalid_argument);
  CheckOptions moved;
  for (const double seconds : {0.5, 0.0}) {
    moved.reading.matching.time_offset_s = seconds;
    EXPECT_THROW(check_logs({&good, 1}, moved), std::invalid_argument) << seconds << ": there are no poses";
  }
  EXPECT_THROW(check_logs({}), std::invalid_argument);
  const std::string twice[] = {good + "/run1.csv", good + "/run1.csv"};
  EXPECT_THROW(check_logs(twice), DataError);
}

}  // namespace
}  // namespace credence::internal
