#include "datasets/logs/trajectory_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "datasets/data_error.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Variances on the diagonal of an upper triangle of six by six.
std::string joint_triangle(double position, double orientation) {
  std::string text;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      text += " " + std::to_string(row != column ? 0.0 : row < 3 ? position : orientation);
    }
  }
  return text;
}

std::string row_of_numbers(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += "1 ";
  return text + "\n";
}

class TrajectoryLog : public ::testing::Test {
 protected:
  /// Ten poses along x, one a second; the estimate stands `off` beside.
  std::filesystem::path estimate(double off) const {
    std::string text = "# t x y z qx qy qz qw\n";
    for (int i = 0; i < 10; ++i) {
      text += std::to_string(i) + " " + std::to_string(i) + " " + std::to_string(off) + " 0 0 0 0 1" +
              joint_triangle(0.04, 0.01) + "\n";
    }
    return folder_.write("estimate.tum", text);
  }
  LogReading with_truth() const {
    std::string text;
    for (int i = 0; i < 8; ++i) text += std::to_string(i) + " " + std::to_string(i) + " 0 0 0 0 0 1\n";
    const std::filesystem::path truth = folder_.write("truth.txt", text);
    LogReading options;
    options.truth = TruthFiles({}, {truth.string()});
    return options;
  }
  TemporaryFolder folder_;
};

TEST_F(TrajectoryLog, ReadsErrorsAgainstTheTruthAndCountsWhatHasNone) {
  testing::RecordedSink sink;
  tum_format().read(estimate(0.25), with_truth(), sink);
  ASSERT_EQ(sink.runs.size(), 1U);
  const auto& steps = sink.runs[0].steps;
  ASSERT_EQ(steps.size(), 8U);
  EXPECT_EQ(sink.unmatched_rows, 2);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    // x̂ ⊟ x: the estimate stands 0.25 m to the left.
    EXPECT_LT((steps[i].error.cwiseAbs() - Vector{{0.0, 0.25, 0.0, 0.0, 0.0, 0.0}}).norm(), 1e-12);
    EXPECT_NEAR(steps[i].P(0, 0), 0.04, 1e-12);
    EXPECT_NEAR(steps[i].P(5, 5), 0.01, 1e-12);
    EXPECT_NEAR(sink.runs[0].travelled_m[i], static_cast<double>(i), 1e-12);
  }
}

// As texts of bags hold them: z, roll and pitch have no variance, or one of 10⁶.
TEST_F(TrajectoryLog, APoseInThePlaneIsTold) {
  for (const double variance : {0.0, 1e6, 0.25}) {
    std::string text;
    for (int i = 0; i < 10; ++i) {
      text += std::to_string(i) + " " + std::to_string(i) + " 0 0 0 0 0 1";
      for (int row = 0; row < 6; ++row) {
        for (int column = row; column < 6; ++column) {
          const bool in_plane = row < 2 || row == 5;
          text += " " + std::to_string(row != column ? 0.0 : in_plane ? 0.04 : variance);
        }
      }
      text += "\n";
    }
    testing::RecordedSink sink;
    tum_format().read(folder_.write("plane.tum", text), with_truth(), sink);
    const auto matcher = HasSubstr("judge it by --chart planar");
    if (variance == 0.25) {
      EXPECT_THAT(sink.said(), ::testing::Not(matcher));
    } else {
      EXPECT_THAT(sink.said(), matcher) << variance;
    }
  }
}

TEST_F(TrajectoryLog, WithoutATruthSaysHowToNameIt) {
  testing::RecordedSink sink;
  const std::filesystem::path file = estimate(0.0);
  EXPECT_THAT([&] { tum_format().read(file, {}, sink); },
              ThrowsMessage<std::invalid_argument>(HasSubstr(
                  "estimate.tum: a trajectory (tum) has no truth in it: name the truth by --truth")));
}

TEST_F(TrajectoryLog, AChartIsForFilesThatDoNotSayIt) {
  testing::RecordedSink sink;
  LogReading options = with_truth();
  options.chart = pose_chart_of(OrientationError::world);
  const std::filesystem::path file = estimate(0.0);
  EXPECT_NO_THROW(tum_format().read(file, options, sink));
  EXPECT_THAT([&] { openvins_format().read(file, options, sink); },
              ThrowsMessage<std::invalid_argument>(
                  HasSubstr("--chart: files of --input openvins say it themselves; accepted is planar")));
}

TEST_F(TrajectoryLog, TheTruthIsNamedAfterTheLogIsListed) {
  const LogContents contents = tum_format().list(estimate(0.0));
  ASSERT_EQ(contents.topics.size(), 1U);
  EXPECT_EQ(contents.topics[0].count, 10);
  EXPECT_EQ(contents.topics[0].type, "tum");
  EXPECT_NEAR(contents.topics[0].rate_hz, 1.0, 1e-12);
  EXPECT_TRUE(contents.topics[0].covariance);
  EXPECT_THAT(std::string(contents.remark), HasSubstr("--truth"));
  EXPECT_THROW(tum_format().list(folder_.write("none.tum", "# nothing\n")), DataError);
}

TEST_F(TrajectoryLog, AFormatIsKnownByItsColumns) {
  struct Beginning {
    std::string text;
    bool tum, openvins, cnspy;
  };
  const std::string header = "t,tx,ty,tz,qx,qy,qz,qw,pxx,pxy,pxz,pyy,pyz,pzz,qrr,qrp,qry,qpp,qpy,qyy\n1,2\n";
  const Beginning cases[] = {{row_of_numbers(29), true, false, false},
                             {row_of_numbers(8), true, false, false},
                             {row_of_numbers(20), false, true, false},
                             {row_of_numbers(21), false, false, false},
                             {"# a comment\n \t\n" + row_of_numbers(20), false, true, false},
                             {"1 2 3 4 5 6 7 8\r\n9", true, false, false},
                             {"1 2 3 4 5 6 7 word\n", false, false, false},
                             {"1 2 3 4 5 6 7 nan\n", false, false, false},
                             {header, false, false, true},
                             {"", false, false, false},
                             {"# only a comment", false, false, false},
                             {std::string("\0\x01\x02", 3), false, false, false}};
  for (const Beginning& b : cases) {
    EXPECT_EQ(tum_format().recognises(b.text, {}), b.tum) << b.text;
    EXPECT_EQ(openvins_format().recognises(b.text, {}), b.openvins) << b.text;
    EXPECT_EQ(cnspy_format().recognises(b.text, {}), b.cnspy) << b.text;
  }
}

}  // namespace
}  // namespace credence::internal
