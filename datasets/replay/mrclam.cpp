#include "datasets/replay/mrclam.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "core/manifold/angle.h"
#include "datasets/data_error.h"
#include "datasets/logs/text_table.h"
#include "datasets/replay/mrclam_checks.h"

namespace credence::internal {
namespace {

constexpr int kRobots = 5;
constexpr double kFarthest_m = 1e6, kFastest = 1e3;  // m/s and rad/s
// The files print four decimals and so may say 3.1416 for π.
constexpr double kMaxAngleRad = std::numbers::pi + 1e-4;

int whole_number(const TextTable& table, Index row, Index column, const char* name) {
  const double value = table.values(row, column);
  if (value != std::floor(value) || value < 0 || value > 1e6)
    table.fail(row, fmt::format("{} {} is not a whole number", name, value));
  return static_cast<int>(value);
}

void check_angle(const TextTable& table, Index row, Index column, const char* name) {
  const double angle = table.values(row, column);
  if (std::abs(angle) > kMaxAngleRad) table.fail(row, fmt::format("{} {} rad is beyond pi", name, angle));
}

/// What no robot does and no room holds is a damaged number.
void check_size(const TextTable& table, Index row, Index column, const char* name, double most,
                const char* unit) {
  const double value = table.values(row, column);
  if (std::abs(value) > most)
    table.fail(row, fmt::format("{} {:g} {} is beyond {:g} {}", name, value, unit, most, unit));
}

/// A table whose first column is time, in order.
TextTable read_timed_table(const std::filesystem::path& file, Index columns) {
  TextTable table = read_text_table(file, columns);
  for (Index i = 1; i < table.rows(); ++i)
    if (table.values(i, 0) < table.values(i - 1, 0))
      table.fail(i, fmt::format("time goes backwards from {:.3f} to {:.3f} s", table.values(i - 1, 0),
                                table.values(i, 0)));
  return table;
}

/// Which subject wears a barcode.
std::map<int, int> read_subject_of_barcode(const std::filesystem::path& file) {
  const TextTable table = read_text_table(file, 2);
  std::map<int, int> subject_of_barcode, barcode_of_subject;
  for (Index i = 0; i < table.rows(); ++i) {
    const int subject = whole_number(table, i, 0, "subject");
    const int barcode = whole_number(table, i, 1, "barcode");
    if (!subject_of_barcode.emplace(barcode, subject).second)
      table.fail(i, fmt::format("barcode {} is worn twice", barcode));
    if (!barcode_of_subject.emplace(subject, barcode).second)
      table.fail(i, fmt::format("subject {} is named twice", subject));
  }
  return subject_of_barcode;
}

std::vector<MrclamLandmark> read_landmarks(const std::filesystem::path& file,
                                           const std::map<int, int>& subject_of_barcode) {
  const TextTable table = read_text_table(file, 5);
  std::vector<MrclamLandmark> landmarks;
  for (Index i = 0; i < table.rows(); ++i) {
    const int subject = whole_number(table, i, 0, "subject");
    if (std::ranges::none_of(subject_of_barcode, [&](const auto& entry) { return entry.second == subject; }))
      table.fail(i, fmt::format("subject {} wears no barcode in Barcodes.dat", subject));
    if (subject <= kRobots) table.fail(i, fmt::format("subject {} is a robot, not a landmark", subject));
    for (const MrclamLandmark& other : landmarks)
      if (other.subject == subject) table.fail(i, fmt::format("subject {} is named twice", subject));
    const Vector row = table.values.row(i);
    if (row(3) < 0 || row(4) < 0) table.fail(i, "a standard deviation is negative");
    for (const Index column : {1, 2}) check_size(table, i, column, "position", kFarthest_m, "m");
    for (const Index column : {3, 4}) check_size(table, i, column, "standard deviation", kFarthest_m, "m");
    landmarks.push_back({subject, row.segment<2>(1)});
  }
  return landmarks;
}

void read_odometry(const std::filesystem::path& file, MrclamLog& log) {
  const TextTable table = read_timed_table(file, 3);
  for (Index i = 0; i < table.rows(); ++i) {
    check_size(table, i, 1, "speed", kFastest, "m/s");
    check_size(table, i, 2, "turn rate", kFastest, "rad/s");
    log.odometry.push_back({table.values(i, 0), table.values(i, 1), table.values(i, 2)});
  }
}

void read_truth(const std::filesystem::path& file, MrclamLog& log) {
  const TextTable table = read_timed_table(file, 4);
  for (Index i = 0; i < table.rows(); ++i) {
    check_angle(table, i, 3, "heading");
    for (const Index column : {1, 2}) check_size(table, i, column, "position", kFarthest_m, "m");
    log.truth.push_back({table.values(i, 0), table.values.row(i).segment<3>(1)});
  }
}

void read_measurements(const std::filesystem::path& file, const std::map<int, int>& subject_of_barcode,
                       MrclamLog& log) {
  const TextTable table = read_timed_table(file, 4);
  for (Index i = 0; i < table.rows(); ++i) {
    const int barcode = whole_number(table, i, 1, "barcode");
    if (table.values(i, 2) <= 0) table.fail(i, fmt::format("range {} m is not positive", table.values(i, 2)));
    check_size(table, i, 2, "range", kFarthest_m, "m");
    check_angle(table, i, 3, "bearing");
    const auto subject = subject_of_barcode.find(barcode);
    if (subject == subject_of_barcode.end()) {
      ++log.rows_of_unknown_barcodes;
      continue;
    }
    if (subject->second <= kRobots) {
      ++log.rows_of_robots;
      continue;
    }
    const auto landmark = std::ranges::find(log.landmarks, subject->second, &MrclamLandmark::subject);
    if (landmark == log.landmarks.end())
      table.fail(i, fmt::format("subject {} is no landmark of Landmark_Groundtruth.dat", subject->second));
    log.measurements.push_back({table.values(i, 0),
                                static_cast<std::size_t>(landmark - log.landmarks.begin()),
                                table.values(i, 2), table.values(i, 3)});
  }
}

}  // namespace

MrclamLog read_mrclam(const std::filesystem::path& folder, int robot) {
  if (robot < 1 || robot > kRobots)
    throw std::invalid_argument(fmt::format("robot {} is not one of 1 to {}", robot, kRobots));
  const std::map<int, int> subject_of_barcode = read_subject_of_barcode(folder / "Barcodes.dat");
  MrclamLog log;
  log.robot = robot;
  log.landmarks = read_landmarks(folder / "Landmark_Groundtruth.dat", subject_of_barcode);
  const auto file = [&](const char* kind) { return folder / fmt::format("Robot{}_{}.dat", robot, kind); };
  read_odometry(file("Odometry"), log);
  read_truth(file("Groundtruth"), log);
  read_measurements(file("Measurement"), subject_of_barcode, log);
  if (const std::string problem = truth_contradiction(log); !problem.empty())
    throw DataError(file("Groundtruth"), "", problem);
  if (const std::string problem = odometry_contradiction(log); !problem.empty())
    throw DataError(file("Odometry"), "", problem);
  if (const std::string problem = measurement_contradiction(log); !problem.empty())
    throw DataError(file("Measurement"), "", problem);
  return log;
}

std::vector<int> mrclam_robots(const std::filesystem::path& folder) {
  std::vector<int> robots;
  for (int robot = 1; robot <= kRobots; ++robot)
    if (std::filesystem::exists(folder / fmt::format("Robot{}_Odometry.dat", robot))) robots.push_back(robot);
  return robots;
}

std::optional<Eigen::Vector3d> truth_at(const std::vector<MrclamPose>& truth, double time_s) {
  constexpr double kLargestGap_s = 0.5;
  const auto after = std::ranges::lower_bound(truth, time_s, {}, &MrclamPose::time_s);
  if (after == truth.end()) return std::nullopt;
  if (after->time_s == time_s) return after->pose;
  if (after == truth.begin()) return std::nullopt;
  const MrclamPose& before = *(after - 1);
  const double gap = after->time_s - before.time_s;
  if (gap > kLargestGap_s) return std::nullopt;
  const double share = (time_s - before.time_s) / gap;
  Eigen::Vector3d step = after->pose - before.pose;
  step(2) = wrap_angle(step(2));
  Eigen::Vector3d pose = before.pose + share * step;
  pose(2) = wrap_angle(pose(2));
  return pose;
}

}  // namespace credence::internal
