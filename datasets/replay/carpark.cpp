#include "datasets/replay/carpark.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "datasets/replay/mat_file.h"

namespace credence::internal {
namespace {

constexpr double kMaxSpeedMps = 50.0;
constexpr double kMaxRangeM = 1000.0;
constexpr double kMaxCoordinateM = 1e5;
constexpr double kSameTimeS = 1e-6;
constexpr Index kBeams = 361;

/// A variable whose numbers all lie in [low, high], with `count` of them (0: any count).
Vector read_within(const MatFile& file, const std::string& name, Index count, double low, double high) {
  Vector values = file.vector(name);
  if (count > 0 && values.size() != count)
    file.fail(name, fmt::format("holds {} numbers where {} are expected", values.size(), count));
  for (Index i = 0; i < values.size(); ++i)
    if (values(i) < low || values(i) > high)
      file.fail(name, fmt::format("number {} is {}, outside [{}, {}]", i + 1, values(i), low, high));
  return values;
}

Vector read_times(const MatFile& file, const std::string& name) {
  Vector times = file.vector(name);
  for (Index i = 1; i < times.size(); ++i)
    if (times(i) < times(i - 1))
      file.fail(name, fmt::format("time goes backwards from {} to {} s at number {}", times(i - 1), times(i),
                                  i + 1));
  return times;
}

void check_beams(const MatFile& file, const std::string& name, const Matrix& scans, Index rows) {
  if (scans.rows() != rows || scans.cols() != kBeams)
    file.fail(name,
              fmt::format("is {}x{} where {}x{} is expected", scans.rows(), scans.cols(), rows, kBeams));
  if (scans.minCoeff() < 0) file.fail(name, "holds a negative number");
}

std::vector<CarparkGps> read_gps(const MatFile& file) {
  const Vector times = read_times(file, "TimeGPS");
  const Vector east = read_within(file, "GPSLon", times.size(), -kMaxCoordinateM, kMaxCoordinateM);
  const Vector north = read_within(file, "GPSLat", times.size(), -kMaxCoordinateM, kMaxCoordinateM);
  std::vector<CarparkGps> result;
  for (Index i = 0; i < times.size(); ++i) result.push_back({times(i), {east(i), north(i)}});
  return result;
}

std::vector<CarparkOdometry> read_odometry(const MatFile& file) {
  const Vector times = read_times(file, "Time_VS");
  const Vector speed = read_within(file, "Velocity", times.size(), -kMaxSpeedMps, kMaxSpeedMps);
  constexpr double kRightAngle = std::numbers::pi / 2;
  const Vector steering = read_within(file, "Steering", times.size(), -kRightAngle, kRightAngle);
  std::vector<CarparkOdometry> result;
  for (Index i = 0; i < times.size(); ++i) result.push_back({times(i), speed(i), steering(i)});
  return result;
}

std::vector<CarparkScan> read_scans(const MatFile& file) {
  const Vector times = read_times(file, "TimeLaser");
  const Matrix ranges = file.matrix("Laser");
  check_beams(file, "Laser", ranges, times.size());
  if (ranges.maxCoeff() > kMaxRangeM) file.fail("Laser", fmt::format("holds a range above {} m", kMaxRangeM));
  const Matrix intensities = file.matrix("Intensity");
  check_beams(file, "Intensity", intensities, times.size());
  std::vector<CarparkScan> result;
  for (Index i = 0; i < times.size(); ++i) result.push_back({times(i), ranges.row(i), intensities.row(i)});
  return result;
}

double time_of(const CarparkLog& log, CarparkSensor sensor, std::size_t index) {
  switch (sensor) {
    case CarparkSensor::gps: return log.gps[index].time_s;
    case CarparkSensor::odometry: return log.odometry[index].time_s;
    case CarparkSensor::laser: return log.scans[index].time_s;
  }
  return 0;
}

/// The merged record; every sample of every sensor must be named once, in its own order and at its own time.
std::vector<CarparkEvent> read_events(const MatFile& file, const CarparkLog& log) {
  const Vector times = read_times(file, "Time");
  const Vector sensors = read_within(file, "Sensor", times.size(), 1, 3);
  const Vector indices = file.vector("Index");
  if (indices.size() != times.size())
    file.fail("Index", fmt::format("holds {} numbers where {} are expected", indices.size(), times.size()));

  const std::size_t sizes[] = {log.gps.size(), log.odometry.size(), log.scans.size()};
  std::size_t next[] = {0, 0, 0};
  std::vector<CarparkEvent> events;
  for (Index i = 0; i < times.size(); ++i) {
    if (sensors(i) != std::floor(sensors(i)))
      file.fail("Sensor", fmt::format("number {} is {}, not 1, 2 or 3", i + 1, sensors(i)));
    const auto which = static_cast<std::size_t>(sensors(i)) - 1;
    const std::size_t index = next[which]++;
    if (index >= sizes[which] || indices(i) != static_cast<double>(index + 1))
      file.fail("Index", fmt::format("number {} is {} where sample {} of {} of sensor {} is due", i + 1,
                                     indices(i), index + 1, sizes[which], which + 1));
    const auto sensor = static_cast<CarparkSensor>(which + 1);
    const double own_time = time_of(log, sensor, index);
    if (std::abs(times(i) - own_time) > kSameTimeS)
      file.fail("Time", fmt::format("number {} is {} s, its sample has {} s", i + 1, times(i), own_time));
    events.push_back({times(i), sensor, index});
  }
  for (std::size_t which = 0; which < 3; ++which)
    if (next[which] != sizes[which])
      file.fail("Index", fmt::format("names {} samples of sensor {}, which has {}", next[which], which + 1,
                                     sizes[which]));
  return events;
}

}  // namespace

CarparkLog read_carpark(const std::filesystem::path& folder) {
  const MatFile file(folder / "data_set.mat");
  CarparkLog log;
  log.gps = read_gps(file);
  log.odometry = read_odometry(file);
  log.scans = read_scans(file);
  log.events = read_events(file, log);

  const MatFile survey(folder / "beac_juan3.mat");
  const Matrix beacons = survey.matrix("estbeac");
  if (beacons.cols() != 2)
    survey.fail("estbeac", fmt::format("has {} columns where East and North are expected", beacons.cols()));
  if (beacons.cwiseAbs().maxCoeff() > kMaxCoordinateM)
    survey.fail("estbeac", fmt::format("holds a coordinate beyond {} m", kMaxCoordinateM));
  for (Index i = 0; i < beacons.rows(); ++i) log.beacons_m.emplace_back(beacons(i, 0), beacons(i, 1));
  return log;
}

}  // namespace credence::internal
