#include <fmt/format.h>
#include <gmock/gmock.h>
#include <matio.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>
#include <random>

#include "analysis/evidence/verdicts/judgement.h"
#include "core/manifold/sek3.h"
#include "datasets/logs/arrays/npz_writer.h"
#include "datasets/logs/judge_logs.h"
#include "datasets/logs/log_format.h"
#include "datasets/logs/ros/pose_bag.h"
#include "tests/datasets/logs/autopilot/dataflash_writer.h"
#include "tests/datasets/logs/autopilot/ulog_writer.h"
#include "tests/datasets/logs/ros/ros_writers.h"
#include "tests/temporary_folder.h"

/// @file
/// A log of each format, written from a consistent and from an inconsistent filter: what is read of it gives
/// the verdict, the causes and the numbers of the same runs in memory.

namespace credence::internal {
namespace {

using testing::BagContent;
using testing::ByteWriter;
using testing::MessageWriter;
using testing::Packing;

constexpr int kRuns = 24, kRows = 30;
constexpr PoseErrorAxes kBody{};

/// A row as the filter has it in memory.
struct PoseRow {
  double time_s = 0.0;
  SpatialPose estimate{}, truth{};
  PoseError error = PoseError::Zero();
  PoseCovariance P = PoseCovariance::Zero();
};
using PoseRun = std::vector<PoseRow>;

SpatialPose truth_on_course(double t) {
  return {{5.0 * std::cos(0.3 * t), 4.0 * std::sin(0.4 * t), 0.1 * t},
          SO3::Exp(Eigen::Vector3d(0.2 * std::sin(t), 0.1, 0.3 * t)).quaternion()};
}

/// Errors in the axes of the body, `factor` times as large in the position as P says.
std::vector<PoseRun> pose_runs(double factor, bool joint) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  std::vector<PoseRun> runs(kRuns);
  for (PoseRun& run : runs) {
    for (int k = 0; k < kRows; ++k) {
      PoseError sigma;
      sigma << 0.2, 0.1, 0.3, 0.01, 0.02, 0.03;
      PoseCovariance C = PoseCovariance::Identity();
      C(0, 1) = C(1, 0) = 0.4;
      if (joint) C(0, 5) = C(5, 0) = -0.3;
      PoseRow row{.time_s = 100.0 + 0.5 * k, .truth = truth_on_course(0.5 * k)};
      row.P = (1.0 + 0.1 * k) * (sigma.asDiagonal() * C * sigma.asDiagonal());
      row.error = row.P.llt().matrixL() * PoseError::NullaryExpr([&] { return normal(random); });
      row.error.head<3>() *= factor;
      row.estimate = {row.truth.position + row.error.head<3>(),
                      row.truth.orientation * SO3::Exp(row.error.tail<3>()).quaternion()};
      run.push_back(row);
    }
  }
  return runs;
}

Judgement in_memory(const std::vector<PoseRun>& runs, const RunLayout& layout, Index states) {
  EvidenceRecorder sums(layout);
  for (const PoseRun& run : runs) {
    sums.begin_run();
    for (std::size_t k = 0; k < run.size(); ++k) {
      Step step;
      step.step = static_cast<std::int64_t>(k) + 1;
      for (Index i = 0; i < states; ++i) step.states.push_back(i);
      step.error = run[k].error.head(states);
      step.P = run[k].P.topLeftCorner(states, states);
      sums.add(step);
    }
  }
  return judge(sums.take());
}

void expect_the_same(const Judgement& read, const Judgement& memory, double precision,
                     const std::string& what) {
  const auto near = [&](double a, double b, const std::string& name) {
    EXPECT_NEAR(a, b, precision * std::abs(b)) << what << ' ' << name;
  };
  EXPECT_EQ(read.word.verdict, memory.word.verdict) << what;
  EXPECT_EQ(read.nees.verdict, memory.nees.verdict) << what;
  EXPECT_EQ(read.nis.verdict, memory.nis.verdict) << what;
  if (memory.nees.count > 0) near(read.nees.mean, memory.nees.mean, "NEES");
  if (memory.nis.count > 0) near(read.nis.mean, memory.nis.mean, "NIS");
  ASSERT_EQ(read.blocks.size(), memory.blocks.size()) << what;
  for (std::size_t b = 0; b < memory.blocks.size(); ++b) {
    near(read.blocks[b].verdict.mean, memory.blocks[b].verdict.mean, memory.blocks[b].name);
    EXPECT_EQ(read.blocks[b].verdict.verdict, memory.blocks[b].verdict.verdict) << what;
  }
  EXPECT_EQ(read.responsible.index, memory.responsible.index) << what;
  ASSERT_EQ(read.causes.size(), memory.causes.size()) << what;
  for (std::size_t c = 0; c < memory.causes.size(); ++c)
    EXPECT_EQ(read.causes[c].cause, memory.causes[c].cause) << what;
  ASSERT_EQ(read.tests.size(), memory.tests.size()) << what;
  for (std::size_t t = 0; t < memory.tests.size(); ++t) {
    if (std::isnan(memory.tests[t].p_value)) continue;
    EXPECT_NEAR(read.tests[t].p_value, memory.tests[t].p_value, 1e3 * precision)
        << what << ' ' << memory.tests[t].name;
  }
}

/// What is read of these files, one for each run.
Judgement judge_files(const LogFormat& format, const std::vector<std::filesystem::path>& files,
                      const LogReading& options) {
  LogJudgeOptions one_thread;
  one_thread.threads = 1;
  const LogFileReader read = [&](const std::filesystem::path& file, LogSink& sink) {
    format.read(file, options, sink);
  };
  return judge(judge_logs(files, read, one_thread).evidence);
}

std::string numbers(const auto& values) {
  std::string text;
  for (const double value : values) text += fmt::format(" {:.17g}", value);
  return text;
}

std::string pose_numbers(const SpatialPose& pose) {
  return numbers(pose.position) + numbers(pose.orientation.coeffs());
}

std::string upper_triangle(const Matrix& P) {
  std::string text;
  for (Index i = 0; i < P.rows(); ++i) text += numbers(P.row(i).tail(P.cols() - i));
  return text;
}

std::string truth_text(const PoseRun& run) {
  std::string text;
  for (const PoseRow& row : run) text += fmt::format("{:.17g}{}\n", row.time_s, pose_numbers(row.truth));
  return text;
}

using RowText = std::function<std::string(const PoseRow&)>;

std::string commas(std::string text) {
  for (char& c : text) c = c == ' ' ? ',' : c;
  return text;
}

class EveryFormat : public ::testing::TestWithParam<double> {
 protected:
  /// A text of one row for each pose, with the truth in a file of its own.
  void expect_of_text(const std::string& format, bool joint, const std::string& header, const RowText& text) {
    const std::vector<PoseRun> runs = pose_runs(GetParam(), joint);
    std::vector<std::filesystem::path> files;
    std::vector<std::string> truths;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      std::string content = header;
      for (const PoseRow& row : runs[r]) content += text(row) + "\n";
      files.push_back(folder_.write(fmt::format("{}-{}.txt", format, r), content));
      truths.push_back(folder_.write(fmt::format("truth-{}.txt", r), truth_text(runs[r])).string());
    }
    LogReading options;
    options.truth = TruthFiles(files, truths);
    expect_the_same(judge_files(log_format_named(format), files, options), in_memory(runs, layout(joint), 6),
                    1e-9, format);
  }

  static RunLayout layout(bool joint) { return TruthComparison(Trajectory(), {}, kBody, joint).layout(); }

  BagContent bag_of(const PoseRun& run, MessageWriter::Kind kind) const {
    BagContent bag{.topics = {{"/odom", "nav_msgs/Odometry"}, {"/gt", "geometry_msgs/PoseStamped"}},
                   .messages = {}};
    for (const PoseRow& row : run) {
      MessageWriter odometry(kind), truth(kind);
      odometry.header(row.time_s, "map").text("base").pose(row.estimate).matrix(row.P);
      odometry.vector({0, 0, 0}).vector({0, 0, 0}).matrix(PoseCovariance(PoseCovariance::Zero()));
      truth.header(row.time_s, "map").pose(row.truth);
      bag.messages.push_back({0, row.time_s, odometry.bytes()});
      bag.messages.push_back({1, row.time_s, truth.bytes()});
    }
    return bag;
  }

  TemporaryFolder folder_;
};

TEST_P(EveryFormat, TrajectoriesAsText) {
  const auto row = [](const PoseRow& r) {
    return fmt::format("{:.17g}", r.time_s) + pose_numbers(r.estimate);
  };
  expect_of_text("tum", true, "", [&](const PoseRow& r) { return row(r) + upper_triangle(r.P); });
  const auto blocks = [](const PoseRow& r, bool rotation_first) {
    const std::string p = upper_triangle(r.P.topLeftCorner<3, 3>()),
                      q = upper_triangle(r.P.bottomRightCorner<3, 3>());
    return rotation_first ? q + p : p + q;
  };
  expect_of_text("openvins", false, "", [&](const PoseRow& r) { return row(r) + blocks(r, true); });
  expect_of_text("cnspy", false, "t,tx,ty,tz,qx,qy,qz,qw,pxx,pxy,pxz,pyy,pyz,pzz,qrr,qrp,qry,qpp,qpy,qyy\n",
                 [&](const PoseRow& r) { return commas(row(r) + blocks(r, false)); });
}

TEST_P(EveryFormat, BagsOfRos) {
  const std::vector<PoseRun> runs = pose_runs(GetParam(), true);
  const Judgement memory = in_memory(runs, layout(true), 6);
  LogReading options;
  options.truth_topic = "/gt";
  options.chart = pose_chart_named("body");
  std::vector<std::filesystem::path> mcap, bag, db3;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const BagContent cdr = bag_of(runs[r], MessageWriter::Kind::cdr);
    mcap.push_back(folder_.write(fmt::format("{}.mcap", r), testing::mcap_bytes(cdr, Packing::zstd)));
    bag.push_back(
        folder_.write(fmt::format("{}.bag", r),
                      testing::ros1_bag_bytes(bag_of(runs[r], MessageWriter::Kind::ros1), Packing::lz4)));
    db3.push_back(folder_ / fmt::format("{}.db3", r));
    testing::write_ros2_sqlite(db3.back(), cdr);
  }
  expect_the_same(judge_files(log_format_named("mcap"), mcap, options), memory, 1e-9, "mcap");
  expect_the_same(judge_files(log_format_named("rosbag"), bag, options), memory, 1e-9, "rosbag");
  expect_the_same(judge_files(log_format_named("db3"), db3, options), memory, 1e-9, "db3");
  // The writer of `run --log-format mcap`, whose chart is that of the standard.
  std::vector<std::filesystem::path> own;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    std::vector<LoggedPose> poses;
    for (const PoseRow& row : runs[r]) poses.push_back({row.time_s, row.estimate, row.P, row.truth});
    own.push_back(folder_.write(fmt::format("own-{}.mcap", r), pose_bag_bytes(poses)));
  }
  options.truth_topic = kPoseBagTruth;
  expect_the_same(judge_files(log_format_named("mcap"), own, options), memory, 1e-9, "own mcap");
}

TEST_P(EveryFormat, PositioningSolutions) {
  const std::vector<PoseRun> runs = pose_runs(GetParam(), false);
  const std::string header =
      "%  GPST  e-baseline(m) n-baseline(m) u-baseline(m) Q ns sde(m) sdn(m) sdu(m) sden(m) sdnu(m) sdue(m) "
      "age(s) ratio\n";
  const auto line = [](int k, const Eigen::Vector3d& place, const std::vector<double>& sd) {
    return fmt::format("2020/01/01 00:00:{:06.3f}{} 1 9{} 0 9\n", 0.5 * k, numbers(place), numbers(sd));
  };
  std::vector<std::filesystem::path> files;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    std::string text = header;
    for (int k = 0; k < kRows; ++k) {
      const PoseRow& row = runs[r][static_cast<std::size_t>(k)];
      const auto root = [&](Index i, Index j) {
        return std::copysign(std::sqrt(std::abs(row.P(i, j))), row.P(i, j));
      };
      text += line(k, row.error.head<3>(),
                   {root(0, 0), root(1, 1), root(2, 2), root(0, 1), root(1, 2), root(0, 2)});
    }
    files.push_back(folder_.write(fmt::format("{}.pos", r), text));
  }
  LogReading options;
  options.truth = TruthFiles(
      files,
      {folder_.write("point.pos", header + line(0, Eigen::Vector3d::Zero(), std::vector<double>(6, 0.0)))
           .string()});
  RunLayout fixes{.states = {"fix.east", "fix.north", "fix.up"}, .angles = {false, false, false}};
  add_named_blocks(fixes);
  expect_the_same(judge_files(log_format_named("rtklib"), files, options), in_memory(runs, fixes, 3), 1e-9,
                  "rtklib");
}

TEST_P(EveryFormat, ArraysOfNumpy) {
  const std::vector<PoseRun> runs = pose_runs(GetParam(), true);
  NamedArray error{"error", {kRuns, kRows, 6}, {}}, P{"P", {kRuns, kRows, 6, 6}, {}};
  for (const PoseRun& run : runs) {
    for (const PoseRow& row : run) {
      error.values.insert(error.values.end(), row.error.begin(), row.error.end());
      P.values.insert(P.values.end(), row.P.reshaped().begin(), row.P.reshaped().end());
    }
  }
  RunLayout states{.states = {"x1", "x2", "x3", "x4", "x5", "x6"}, .angles = std::vector<bool>(6, false)};
  add_named_blocks(states);
  const std::vector<std::filesystem::path> files = {
      folder_.write("runs.npz", npz_bytes(std::vector<NamedArray>{error, P}))};
  expect_the_same(judge_files(log_format_named("npz"), files, {}), in_memory(runs, states, 6), 1e-12, "npz");
}

TEST_P(EveryFormat, ArraysOfMatlab) {
  const std::vector<PoseRun> runs = pose_runs(GetParam(), true);
  std::vector<std::size_t> dims = {kRuns, kRows, 6, 6};
  std::vector<double> error, P;  // run by run, then row by row, then component by component
  for (Index i = 0; i < 36; ++i) {
    for (std::size_t k = 0; k < kRows; ++k) {
      for (const PoseRun& run : runs) {
        if (i < 6) error.push_back(run[k].error[i]);
        P.push_back(run[k].P(i % 6, i / 6));
      }
    }
  }
  const std::filesystem::path file = folder_ / "runs.mat";
  mat_t* const mat = Mat_CreateVer(file.c_str(), nullptr, MAT_FT_MAT5);
  for (const auto& [name, rank, values] : {std::tuple("error", 3, &error), std::tuple("P", 4, &P)}) {
    matvar_t* const array =
        Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, rank, dims.data(), values->data(), 0);
    Mat_VarWrite(mat, array, MAT_COMPRESSION_ZLIB);
    Mat_VarFree(array);
  }
  Mat_Close(mat);
  RunLayout states{.states = {"x1", "x2", "x3", "x4", "x5", "x6"}, .angles = std::vector<bool>(6, false)};
  add_named_blocks(states);
  expect_the_same(judge_files(log_format_named("mat"), {file}, {}), in_memory(runs, states, 6), 1e-12, "mat");
}

// Roots of test ratios in steps of 0.01, with a gate of 1: NIS to about 1 %, and so many that are equal that
// their law is not tested.
TEST_P(EveryFormat, FlightLogsInHundredths) {
  testing::DataflashWriter log;
  log.parameter("EK3_HGT_I_GATE", 100.0F);
  RunLayout height{.sensors = {{.name = "height", .dim = 1, .piece = 1}}};
  height.has_truth = false;
  EvidenceRecorder sums(height);
  sums.begin_run();
  std::int64_t k = 0;
  for (const PoseRun& run : pose_runs(GetParam(), false)) {
    for (const PoseRow& row : run) {
      const double nu = row.error.z(), S = row.P(2, 2);
      const auto time = static_cast<std::uint64_t>(100'000 * ++k);
      log.innovations(time, 0, {0.0, 0.0, 0.0, 0.0, 0.0, nu, 0.0});
      log.ratios(time, 0, {0.0, 0.0, std::abs(nu) / std::sqrt(S), 0.0, 0.0});
      Step step;
      step.step = k;
      step.innovations = {{Vector::Constant(1, nu), Matrix::Constant(1, 1, S)}};
      sums.add(step);
    }
  }
  const Judgement memory = judge(sums.take());
  const Judgement read =
      judge_files(log_format_named("dataflash"), {folder_.write("a.bin", log.bytes())}, {});
  EXPECT_EQ(read.word.verdict, memory.word.verdict);
  EXPECT_EQ(read.nis.verdict, memory.nis.verdict);
  EXPECT_NEAR(read.nis.mean, memory.nis.mean, 0.02 * memory.nis.mean);
  ASSERT_EQ(read.causes.size(), memory.causes.size());
  for (std::size_t c = 0; c < memory.causes.size(); ++c)
    EXPECT_EQ(read.causes[c].cause, memory.causes[c].cause);
  ASSERT_EQ(read.sensors.size(), 1U);
  EXPECT_NEAR(read.sensors[0].whiteness.p_value, memory.sensors[0].whiteness.p_value, 0.2);
  EXPECT_THAT(std::string(read.sensors[0].fit.reason), ::testing::HasSubstr("rounded"));
  EXPECT_TRUE(memory.sensors[0].fit.reason.empty());
}

// Innovations, in the digits of float: of variances that are not exact neither is NIS.
TEST_P(EveryFormat, FlightLogs) {
  const std::vector<PoseRun> runs = pose_runs(GetParam(), false);
  testing::UlogWriter innovations, ratios;
  innovations.format(
      "estimator_aid_src_gnss:uint64_t timestamp;uint64_t timestamp_sample;float[3] innovation;"
      "float[3] innovation_variance;");
  innovations.subscribe(1, 0, "estimator_aid_src_gnss");
  ratios.format(
      "estimator_innovation_test_ratios:uint64_t timestamp;uint64_t timestamp_sample;float gps_vpos;");
  ratios.subscribe(1, 0, "estimator_innovation_test_ratios");
  RunLayout sensors{.sensors = {{.name = "gnss", .dim = 3, .piece = 3, .variances_alone = true}}};
  RunLayout alone{.sensors = {{.name = "gps_vpos", .dim = 1, .piece = 1, .nis_alone = true}}};
  sensors.has_truth = alone.has_truth = false;
  EvidenceRecorder sums(sensors), sums_alone(alone);
  sums.begin_run();
  sums_alone.begin_run();
  std::int64_t k = 0;
  for (const PoseRun& run : runs) {
    for (const PoseRow& row : run) {
      const Eigen::Vector3d nu = row.error.head<3>(), variance = row.P.diagonal().head<3>();
      const auto time = static_cast<std::uint64_t>(10'000 * ++k);
      const double nis = nu.z() * nu.z() / variance.z();
      ByteWriter source, ratio;
      source.add(time).add(time);
      for (const double value : nu) source.add(static_cast<float>(value));
      for (const double value : variance) source.add(static_cast<float>(value));
      innovations.data(1, source.bytes());
      ratios.data(1, ratio.add(time).add(time).add(static_cast<float>(nis / 25.0)).bytes());
      Step step;
      step.step = k;
      step.innovations = {{nu, variance.asDiagonal()}};
      sums.add(step);
      step.innovations = {nis_alone(nis)};
      sums_alone.add(step);
    }
  }
  expect_the_same(judge_files(log_format_named("ulog"), {folder_.write("a.ulg", innovations.bytes())}, {}),
                  judge(sums.take()), 1e-5, "ulog");
  expect_the_same(judge_files(log_format_named("ulog"), {folder_.write("b.ulg", ratios.bytes())}, {}),
                  judge(sums_alone.take()), 1e-5, "test ratios");
}

// A consistent filter, and one whose P is half of what it should be in the position.
INSTANTIATE_TEST_SUITE_P(Filters, EveryFormat, ::testing::Values(1.0, 1.4));

}  // namespace
}  // namespace credence::internal
