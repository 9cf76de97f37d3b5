#include "datasets/logs/autopilot/ulog_states.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "core/manifold/angle.h"
#include "datasets/data_error.h"
#include "datasets/logs/autopilot/innovation_series.h"
#include "datasets/logs/autopilot/ulog.h"
#include "datasets/logs/geodesy.h"
#include "datasets/logs/partial_read.h"
#include "datasets/logs/truth_gaps.h"

namespace credence::internal {
namespace {

constexpr std::string_view kStates = "estimator_states", kLocalPosition = "vehicle_local_position";
constexpr std::array<const char*, 6> kStateNames = {"velocity.north", "velocity.east", "velocity.down",
                                                    "position.north", "position.east", "position.down"};
constexpr std::array<const char*, 6> kStateUnits = {"m/s", "m/s", "m/s", "m", "m", "m"};
using VelocityAndPosition = Eigen::Matrix<double, 6, 1>;  ///< velocity, position; m/s, m

/// One row of estimator_states.
struct EstimatedMotion {
  double time_s = 0.0;
  std::int64_t line = 0;
  VelocityAndPosition value, variance;
};

/// Where the origin of local positions is: latitude, longitude (rad), height (m); nothing where it is not
/// told.
std::optional<Eigen::Vector3d> origin(const UlogTopic& topic, const ByteCursor& message) {
  Eigen::Vector3d place;
  const char* const names[] = {"ref_lat", "ref_lon", "ref_alt"};
  for (Index i = 0; i < 3; ++i) {
    const UlogField* const field = topic.field(names[i]);
    place[i] = field == nullptr ? NAN : ulog_number(message, *field);
  }
  if (!place.allFinite() || place.head<2>().isZero(0.0)) return std::nullopt;
  place.head<2>() *= kRadiansPerDegree;
  return place;
}

/// What a flight says of its states and of the truth.
struct MotionLog {
  Trajectory velocity, position;  ///< of the truth
  std::map<int, std::vector<EstimatedMotion>> estimates;
  std::optional<Eigen::Vector3d> true_origin, estimated_origin;

  void add(const UlogTopic& topic, const ByteCursor& message) {
    if (topic.name == kUlogTruth) return add_truth(topic, message);
    if (topic.name == kLocalPosition) {
      if (const auto place = origin(topic, message)) estimated_origin = place;
      return;
    }
    const UlogField* const states = topic.field("states");
    const UlogField* const variances = topic.field("covariances");
    constexpr std::uint64_t kFirst = 4;
    if (states == nullptr || variances == nullptr || states->count < kFirst + 6) return;
    const std::uint64_t shift = variances->count < states->count ? 1 : 0;
    if (variances->count < kFirst + 6 - shift) return;
    std::vector<EstimatedMotion>& rows = estimates[topic.instance];
    EstimatedMotion row{
        .time_s = ulog_time_s(topic, message), .line = std::ssize(rows) + 1, .value = {}, .variance = {}};
    for (std::uint64_t i = 0; i < 6; ++i) {
      row.value[static_cast<Index>(i)] = ulog_number(message, *states, kFirst + i);
      row.variance[static_cast<Index>(i)] = ulog_number(message, *variances, kFirst + i - shift);
    }
    rows.push_back(row);
  }

 private:
  void add_truth(const UlogTopic& topic, const ByteCursor& message) {
    if (const auto place = origin(topic, message)) true_origin = place;
    const double time_s = ulog_time_s(topic, message);
    if (!velocity.time_s.empty() && !(time_s > velocity.time_s.back())) return;
    add_vector(velocity, time_s, topic, message, {"vx", "vy", "vz"});
    add_vector(position, time_s, topic, message, {"x", "y", "z"});
  }

  static void add_vector(Trajectory& to, double time_s, const UlogTopic& topic, const ByteCursor& message,
                         const std::array<const char*, 3>& names) {
    SpatialPose pose;
    for (std::size_t i = 0; i < 3; ++i) {
      const UlogField* const field = topic.field(names[i]);
      if (field == nullptr) message.fail(fmt::format("topic {} without a field {}", topic.name, names[i]));
      pose.position[static_cast<Index>(i)] = ulog_number(message, *field);
    }
    to.time_s.push_back(time_s);
    to.poses.push_back(pose);
  }
};

/// The truth's origin in the axes of the estimate: north, east, down.
Eigen::Vector3d between_origins(const Eigen::Vector3d& truth, const Eigen::Vector3d& estimate) {
  const Eigen::Vector3d enu = east_north_up(estimate) * (earth_fixed(truth) - earth_fixed(estimate));
  return {enu.y(), enu.x(), -enu.z()};
}

const std::vector<EstimatedMotion>& chosen(const MotionLog& log, const std::filesystem::path& file,
                                           const LogReadOptions& options) {
  if (log.estimates.empty()) {
    throw DataError(file, "", "holds no estimator_states (set SDLOG_PROFILE to log them)");
  }
  const auto found = options.instance ? log.estimates.find(*options.instance) : log.estimates.begin();
  if (found != log.estimates.end()) return found->second;
  std::set<int> instances;
  for (const auto& [instance, rows] : log.estimates) instances.insert(instance);
  throw std::invalid_argument(fmt::format("{}: --instance {}: there are {}", file.string(), *options.instance,
                                          fmt::join(instances, ", ")));
}

/// The same deviations of the first n states; velocities and positions are of the same times.
std::vector<Vector> deviations_of(const std::vector<TruthDeviation>& velocity,
                                  const std::vector<TruthDeviation>& position, Index n) {
  std::vector<Vector> both;
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    VelocityAndPosition d;
    d << velocity[i].position, position[i].position;
    both.emplace_back(d.head(n));
  }
  return both;
}

MotionLog read_motion(const std::filesystem::path& file, const LogReadOptions& options, LogSink& sink) {
  MotionLog log;
  std::map<std::size_t, UlogTopic> topics;
  const UlogVisitor visitor{
      .topic =
          [&](std::size_t i, const UlogTopic& topic) {
            if (topic.name == kStates || topic.name == kUlogTruth || topic.name == kLocalPosition)
              topics.emplace(i, topic);
          },
      .message =
          [&](std::size_t i, const ByteCursor& message) {
            if (const auto found = topics.find(i); found != topics.end()) log.add(found->second, message);
          },
      .advance = [&](std::int64_t bytes) { sink.advance(bytes); }};
  read_part(
      options, sink, [&] { read_ulog(file, visitor); }, [&] { return !log.estimates.empty(); });
  if (log.velocity.time_s.empty()) {
    throw DataError(file, "", fmt::format("--truth-topic {}: it holds no messages", kUlogTruth));
  }
  return log;
}

/// Of the first n states, each a block by itself.
RunLayout motion_layout(Index n) {
  RunLayout layout;
  layout.joint_covariance = false;
  for (Index i = 0; i < n; ++i) {
    const auto place = static_cast<std::size_t>(i);
    const char* const name = kStateNames[place];
    layout.states.emplace_back(name);
    layout.angles.push_back(false);
    layout.units.emplace_back(kStateUnits[place]);
    layout.blocks.push_back({name, Part::other, {i}});
  }
  return layout;
}

}  // namespace

void judge_ulog_states(const std::filesystem::path& file, const LogReadOptions& options, LogSink& sink) {
  const MotionLog log = read_motion(file, options, sink);
  const std::vector<EstimatedMotion>& rows = chosen(log, file, options);
  const bool has_origins = log.true_origin && log.estimated_origin;
  const Eigen::Vector3d shift = has_origins ? between_origins(*log.true_origin, *log.estimated_origin)
                                            : Eigen::Vector3d(Eigen::Vector3d::Zero());
  // A height of exactly 0 is one that nobody has set.
  const bool has_heights = has_origins && log.true_origin->z() != 0.0 && log.estimated_origin->z() != 0.0;
  const Index n = has_heights ? 6 : has_origins ? 5 : 3;
  sink.begin_run(motion_layout(n));
  Step step;
  for (Index i = 0; i < n; ++i) step.states.push_back(i);
  TruthGaps gaps(log.velocity, options.matching);
  const TruthGaps position_gaps(log.position, options.matching);
  std::int64_t unmatched = 0, not_finite = 0;
  for (const EstimatedMotion& row : rows) {
    if (!row.value.head(n).allFinite() || !row.variance.head(n).allFinite()) {
      ++not_finite;
      continue;
    }
    const auto velocity = truth_at(log.velocity, row.time_s, options.matching);
    const auto position = truth_at(log.position, row.time_s, options.matching);
    if (!velocity || !position) {
      ++unmatched;
      continue;
    }
    VelocityAndPosition truth;
    truth << velocity->pose.position, position->pose.position + shift;
    step.P = Matrix(row.variance.head(n).asDiagonal());
    if (is_any_too_far(deviations_of(gaps.at(row.time_s), position_gaps.at(row.time_s), n), step.P)) {
      gaps.leave_out();
      continue;
    }
    ++step.step;
    step.line = row.line;
    step.error = (row.value - truth).head(n);
    sink.at(row.time_s);
    sink.add(step);
  }
  if (not_finite > 0 && not_finite == std::ssize(rows)) {
    throw DataError(file, "", fmt::format("no row of {} has a finite estimate and variance", kStates));
  }
  gaps.tell(file, step.step, sink);
  if (step.step == 0) {
    throw DataError(file, "",
                    fmt::format("no row of {} has a truth at its time, within {} s (--max-time-difference)",
                                kStates, options.matching.max_time_difference_s));
  }
  sink.unmatched(unmatched + gaps.left_out());
  if (not_finite > 0) {
    sink.remark(fmt::format("Left out: {} of {} rows of {}, whose estimate or variance is not finite.",
                            not_finite, rows.size(), kStates));
  }
  sink.remark("The log holds variances and no covariances: every component is judged by itself.");
  if (!has_heights) {
    sink.remark(fmt::format("{} not judged: the log does not hold {} of estimate and truth.",
                            has_origins ? "Heights are" : "Positions are",
                            has_origins ? "the heights of the origins" : "the origins"));
  }
}

}  // namespace credence::internal
