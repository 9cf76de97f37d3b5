#include "datasets/replay/mrclam.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>

#include "core/manifold/angle.h"
#include "datasets/data_error.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

using Texts = std::map<std::string, std::string>;

/// Robot 2 drives 20 m along a circle of radius 3 m at 0.1 m/s and looks at two landmarks.
Texts small_mrclam() {
  Texts texts;
  texts["Barcodes.dat"] = "# subject barcode\n 1 5\n 2 14\n 6 63\n 7 81\n";
  texts["Landmark_Groundtruth.dat"] = "# landmarks\n 6 5 1 0.001 0.002\n 7 -4 2 0.001 0.002\n";
  std::string& odometry = texts["Robot2_Odometry.dat"] = "# odometry\n";
  std::string& truth = texts["Robot2_Groundtruth.dat"] = "# truth\n";
  std::string& measurements = texts["Robot2_Measurement.dat"] = "# measurements\n";
  for (int k = 0; k <= 400; ++k) {
    const double t = 1000 + 0.5 * k, angle = 0.1 / 3 * 0.5 * k;
    const double x = 3 * std::cos(angle), y = 3 * std::sin(angle);
    const double heading = wrap_angle(angle + std::numbers::pi / 2);
    odometry += fmt::format("{:.3f} 0.1 {:.6f}\n", t, 0.1 / 3);
    truth += fmt::format("{:.3f} {:.6f} {:.6f} {:.4f}\n", t, x, y, heading);
    if (k % 20 != 0) continue;
    measurements += fmt::format("{:.3f} 63 {:.3f} {:.3f}\n", t, std::hypot(5 - x, 1 - y),
                                wrap_angle(std::atan2(1 - y, 5 - x) - heading));
    if (k == 40) measurements += fmt::format("{:.3f} 5 1.0 0.1\n{:.3f} 77 1.0 0.1\n", t, t);
  }
  return texts;
}

std::string mrclam_error(const TemporaryFolder& folder, const Texts& texts) {
  for (const auto& [name, text] : texts) folder.write(name, text);
  try {
    read_mrclam(folder.path(), 2);
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Mrclam, MapsBarcodesToLandmarksAndCountsTheRest) {
  const TemporaryFolder folder;
  ASSERT_EQ(mrclam_error(folder, small_mrclam()), "no error");
  const MrclamLog log = read_mrclam(folder.path(), 2);
  EXPECT_EQ(log.robot, 2);
  EXPECT_EQ(log.odometry.size(), 401U);
  EXPECT_EQ(log.truth.size(), 401U);
  EXPECT_EQ(log.measurements.size(), 21U);
  EXPECT_EQ(log.rows_of_robots, 1);
  EXPECT_EQ(log.rows_of_unknown_barcodes, 1);
  ASSERT_EQ(log.landmarks.size(), 2U);
  EXPECT_EQ(log.landmarks[log.measurements[0].landmark].subject, 6);
  EXPECT_EQ(log.landmarks[1].position_m, Eigen::Vector2d(-4, 2));
  EXPECT_EQ(mrclam_robots(folder.path()), std::vector<int>{2});
  EXPECT_THROW(read_mrclam(folder.path(), 6), std::invalid_argument);
  EXPECT_THROW(read_mrclam(folder.path(), 3), DataError);
}

TEST(Mrclam, NamesFileAndLineOfWhatIsImpossible) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& name, const std::string& text) {
    Texts texts = small_mrclam();
    texts[name] = text;
    return mrclam_error(folder, texts);
  };
  EXPECT_THAT(error("Barcodes.dat", "1 5\n2 14\n6 63\n7 63\n"),
              HasSubstr("Barcodes.dat:4: barcode 63 is worn twice"));
  EXPECT_THAT(error("Barcodes.dat", "1 5\n1 14\n6 63\n7 81\n"),
              HasSubstr("Barcodes.dat:2: subject 1 is named twice"));
  EXPECT_THAT(error("Barcodes.dat", "1 5.5\n"),
              HasSubstr("Barcodes.dat:1: barcode 5.5 is not a whole number"));
  EXPECT_THAT(error("Barcodes.dat", "5 1\n14 2\n63 6\n81 7\n"), HasSubstr("subject 6 wears no barcode"));
  EXPECT_THAT(error("Landmark_Groundtruth.dat", "2 0 0 0 0\n"),
              HasSubstr("Groundtruth.dat:1: subject 2 is a robot"));
  EXPECT_THAT(error("Landmark_Groundtruth.dat", "7 0 0 0 0\n"), HasSubstr("subject 6 is no landmark"));
  EXPECT_THAT(error("Landmark_Groundtruth.dat", "6 0 0 0 -1\n"),
              HasSubstr(":1: a standard deviation is negative"));
  EXPECT_THAT(error("Robot2_Odometry.dat", "1001 0.1 0\n1000 0.1 0\n"),
              HasSubstr("Odometry.dat:2: time goes backwards from 1001.000 to 1000.000"));
  EXPECT_THAT(error("Robot2_Odometry.dat", "1000 0.1 1e300\n"),
              HasSubstr("Odometry.dat:1: turn rate 1e+300 rad/s is beyond 1000 rad/s"));
  EXPECT_THAT(error("Robot2_Groundtruth.dat", "1000 3 1e20 0\n"),
              HasSubstr("Groundtruth.dat:1: position 1e+20 m is beyond 1e+06 m"));
  EXPECT_THAT(error("Landmark_Groundtruth.dat", "6 1e20 0 0 0\n"),
              HasSubstr(":1: position 1e+20 m is beyond"));
  EXPECT_THAT(error("Landmark_Groundtruth.dat", "6 0 0 1e300 0\n"),
              HasSubstr(":1: standard deviation 1e+300 m is beyond"));
  EXPECT_THAT(error("Robot2_Groundtruth.dat", "#\n1000 3 0 4.2\n"),
              HasSubstr("Groundtruth.dat:2: heading 4.2"));
  EXPECT_THAT(error("Robot2_Measurement.dat", "1000 63 -1 0\n"), HasSubstr("Measurement.dat:1: range -1"));
  EXPECT_THAT(error("Robot2_Measurement.dat", "1000 63 1 3.5\n"),
              HasSubstr("Measurement.dat:1: bearing 3.5"));
  EXPECT_THAT(error("Robot2_Measurement.dat", "1000 63 1\n"),
              HasSubstr("Measurement.dat:1: 3 numbers where 4"));
}

/// The same rows with columns `a` and `b` exchanged.
std::string swap_columns(const std::string& text, std::size_t a, std::size_t b) {
  std::istringstream lines(text);
  std::string result;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    std::swap(words.at(a), words.at(b));
    result += fmt::format("{}\n", fmt::join(words, " "));
  }
  return result;
}

struct Swap {
  const char* file;
  std::size_t a, b;
};

// All exchanges of two columns but those of the survey's standard deviations, which no other file
// contradicts.
const Swap kSwaps[] = {{"Barcodes.dat", 0, 1},
                       {"Landmark_Groundtruth.dat", 0, 1},
                       {"Landmark_Groundtruth.dat", 1, 2},
                       {"Odometry.dat", 0, 1},
                       {"Odometry.dat", 1, 2},
                       {"Groundtruth.dat", 0, 1},
                       {"Groundtruth.dat", 1, 2},
                       {"Groundtruth.dat", 2, 3},
                       {"Measurement.dat", 0, 1},
                       {"Measurement.dat", 1, 2},
                       {"Measurement.dat", 2, 3}};

TEST(Mrclam, FindsSwappedColumns) {
  for (const Swap& swap : kSwaps) {
    const TemporaryFolder folder;
    Texts texts = small_mrclam();
    for (auto& [name, text] : texts)
      if (name.ends_with(swap.file) && (name.starts_with("Landmark") == (swap.file[0] == 'L')))
        text = swap_columns(text, swap.a, swap.b);
    EXPECT_THAT(mrclam_error(folder, texts), HasSubstr(".dat"))
        << swap.file << " " << swap.a << " " << swap.b;
  }
}

TEST(Mrclam, TruthIsInterpolatedAlongTheShorterArc) {
  constexpr double kPi = std::numbers::pi;
  const std::vector<MrclamPose> truth = {
      {10, {0, 0, kPi - 0.1}}, {10.4, {1, 2, -kPi + 0.3}}, {12, {3, 3, 0}}};
  const auto pose = truth_at(truth, 10.1);
  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR((*pose - Eigen::Vector3d(0.25, 0.5, kPi)).norm(), 0, 1e-12);
  EXPECT_EQ(truth_at(truth, 12)->x(), 3);
  EXPECT_FALSE(truth_at(truth, 11).has_value()) << "a gap of 1.6 s";
  EXPECT_FALSE(truth_at(truth, 9.9).has_value());
  EXPECT_FALSE(truth_at(truth, 12.1).has_value());
  EXPECT_FALSE(truth_at({}, 0).has_value());
}

struct Expected {
  int robot;
  std::size_t odometry, measurements, truth;
  Index robots, unknown;
};

// Counted from the files with awk.
TEST(Mrclam, ReadsTheRealLogs) {
  CREDENCE_DATA_OR_SKIP(data, "mrclam7");
  for (const Expected& expected :
       {Expected{1, 58598, 2578, 58389, 650, 0}, Expected{3, 55085, 4425, 53545, 965, 9}}) {
    const MrclamLog log = read_mrclam(data, expected.robot);
    EXPECT_EQ(log.landmarks.size(), 15U);
    EXPECT_EQ(log.odometry.size(), expected.odometry);
    EXPECT_EQ(log.measurements.size(), expected.measurements);
    EXPECT_EQ(log.truth.size(), expected.truth);
    EXPECT_EQ(log.rows_of_robots, expected.robots);
    EXPECT_EQ(log.rows_of_unknown_barcodes, expected.unknown);
  }
}

// The first lines of the real files, cut anywhere and with bytes flipped: an error with file and line, or
// numbers.
TEST(Mrclam, BrokenTextIsAnErrorOrNumbers) {
  const TemporaryFolder folder;
  const Texts whole = small_mrclam();
  for (const auto& [name, text] : whole) folder.write(name, text);
  std::mt19937 random(7);
  int errors = 0;
  for (int trial = 0; trial < 400; ++trial) {
    auto chosen = whole.begin();
    std::advance(chosen, static_cast<std::ptrdiff_t>(random() % whole.size()));
    std::string broken = chosen->second;
    if (trial % 2 == 0) {
      broken.resize(random() % broken.size());
    } else {
      broken[random() % broken.size()] = static_cast<char>(random());
    }
    folder.write(chosen->first, broken);
    try {
      read_mrclam(folder.path(), 2);
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), HasSubstr(".dat"));
      ++errors;
    }
    folder.write(chosen->first, chosen->second);
  }
  EXPECT_GT(errors, 200);
}

}  // namespace
}  // namespace credence::internal
