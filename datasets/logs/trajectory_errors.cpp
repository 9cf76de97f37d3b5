#include "datasets/logs/trajectory_errors.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/enum_words.h"
#include "datasets/data_error.h"
#include "datasets/logs/alignment.h"
#include "datasets/logs/conventions/convention_check.h"
#include "datasets/logs/distance_travelled.h"
#include "datasets/logs/truth_gaps.h"
#include "datasets/logs/truth_placement.h"
#include "datasets/logs/truth_rows.h"

namespace credence {

std::string_view to_string(TruthAlignment alignment) {
  return internal::word_of(alignment, {"none", "se2", "yaw", "se3"});
}

}  // namespace credence

namespace credence::internal {

std::optional<SpatialPose> lever_arm_of(std::span<const double> a) {
  if (a.empty()) return std::nullopt;
  constexpr std::size_t kPosition = 3, kPose = 7;
  constexpr double kOffUnit = 0.01;
  SpatialPose pose;
  if (a.size() == kPosition || a.size() == kPose) pose.position = {a[0], a[1], a[2]};
  if (a.size() == kPose) pose.orientation = Eigen::Quaterniond(a[6], a[3], a[4], a[5]);
  const bool finite = std::ranges::all_of(a, [](double x) { return std::isfinite(x); });
  if ((a.size() != kPosition && a.size() != kPose) || !finite ||
      !(std::abs(pose.orientation.norm() - 1.0) <= kOffUnit)) {
    throw std::invalid_argument(
        "--lever-arm: accepted are x,y,z (m), or x,y,z,qx,qy,qz,qw with a quaternion of unit length, all "
        "finite");
  }
  pose.orientation.normalize();
  return pose;
}

SpatialPose pose_between(const SpatialPose& a, const SpatialPose& b, double share) {
  return {a.position + share * (b.position - a.position), a.orientation.slerp(share, b.orientation)};
}

double mean_interval_s(const Trajectory& truth) {
  return (truth.time_s.back() - truth.time_s.front()) / static_cast<double>(truth.time_s.size() - 1);
}

TruthAlignment truth_alignment_named(std::string_view name) {
  for (const TruthAlignment alignment :
       {TruthAlignment::none, TruthAlignment::se2, TruthAlignment::yaw, TruthAlignment::se3}) {
    if (name == to_string(alignment)) return alignment;
  }
  throw std::invalid_argument(fmt::format("alignment '{}': accepted are none, se2, yaw, se3", name));
}

namespace {

/// Heading of the truth turned and moved; z moved only if `height`.
Eigen::Isometry3d align_heading(const std::vector<SpatialPose>& truth,
                                const std::vector<SpatialPose>& estimate, bool height) {
  std::vector<Eigen::Vector2d> from, to;
  double rise = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    from.emplace_back(truth[i].position.head<2>());
    to.emplace_back(estimate[i].position.head<2>());
    rise += (estimate[i].position.z() - truth[i].position.z()) / static_cast<double>(truth.size());
  }
  const Eigen::Isometry2d plane = align_rigidly(from, to);
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear().topLeftCorner<2, 2>() = plane.linear();
  motion.translation() << plane.translation(), height ? rise : 0.0;
  return motion;
}

Eigen::Isometry3d align_in_space(const std::vector<SpatialPose>& truth,
                                 const std::vector<SpatialPose>& estimate) {
  Eigen::Matrix3Xd from(3, std::ssize(truth)), to(3, std::ssize(truth));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    from.col(static_cast<Index>(i)) = truth[i].position;
    to.col(static_cast<Index>(i)) = estimate[i].position;
  }
  Eigen::Isometry3d motion;
  motion.matrix() = Eigen::umeyama(from, to, false);
  return motion;
}

std::optional<UncertainPose> truth_as_written(const Trajectory& truth, double time_s,
                                              const TrajectoryMatching& matching) {
  const std::optional<TruthRows> rows = truth_rows(truth.time_s, time_s, matching);
  if (!rows) return std::nullopt;
  const auto covariance = [&](std::size_t i) {
    return truth.covariances.empty() ? PoseCovariance::Zero().eval() : truth.covariances[i];
  };
  const std::size_t i = rows->row;
  const double share = rows->share;
  if (share == 0.0) return UncertainPose{truth.poses[i], covariance(i)};
  return UncertainPose{pose_between(truth.poses[i], truth.poses[i + 1], share),
                       (1.0 - share) * covariance(i) + share * covariance(i + 1)};
}

RunLayout layout_of(PoseErrorAxes axes, bool has_orientation, bool joint_covariance) {
  RunLayout layout;
  layout.joint_covariance = joint_covariance;
  if (axes.orientation == OrientationError::planar) {
    layout.states = {"vehicle.x", "vehicle.y", "vehicle.heading"};
    layout.angles = {false, false, true};
    layout.units = {"m", "m", "rad"};
    layout.states.resize(has_orientation ? 3 : 2);
    layout.angles.resize(layout.states.size());
    layout.units.resize(layout.states.size());
    add_named_blocks(layout);
    return layout;
  }
  layout.states = {"position.x", "position.y", "position.z"};
  layout.angles = {false, false, false};
  layout.units = {"m", "m", "m"};
  layout.blocks = {{"position", Part::position, {0, 1, 2}}};
  if (!has_orientation) return layout;
  const bool rpy = axes.orientation == OrientationError::rpy;
  const std::vector<std::string> names =
      rpy ? std::vector<std::string>{"roll", "pitch", "yaw"} : std::vector<std::string>{"x", "y", "z"};
  for (const std::string& name : names) {
    layout.states.push_back("orientation." + name);
    layout.angles.push_back(rpy);
    // Half a rotation vector and the vector part of a quaternion are not in rad.
    layout.units.emplace_back(axes.unit == RotationUnit::vector ? "rad" : "");
  }
  layout.blocks.push_back({"orientation", Part::other, {3, 4, 5}});
  return layout;
}

/// What takes more rows, where a truth has its own further apart than it may be from an estimate; else "".
std::string more_of_sparse(const Trajectory& truth, const TrajectoryMatching& matching) {
  if (truth.time_s.size() < 2) return "";
  constexpr double kRoom = 1.05;
  const double apart = mean_interval_s(truth);
  if (!(apart > matching.max_time_difference_s)) return "";
  return fmt::format(
      "the rows of the truth are {:.2g} s apart: {}--max-time-difference {:.2g} takes what lies between two "
      "of them as well, where their motion is even enough for P",
      apart,
      matching.truth_time == TruthTime::nearest ? ""
                                                : "--truth-time nearest takes the estimates beside one, ",
      kRoom * apart);
}

}  // namespace

std::optional<UncertainPose> truth_at(const Trajectory& truth, double time_s,
                                      const TrajectoryMatching& matching, const TruthDeviation& deviation) {
  std::optional<UncertainPose> at =
      truth_as_written(truth, time_s + matching.time_offset_s.value_or(0.0), matching);
  if (at) {
    const Eigen::Vector3d& turn = deviation.rotation;
    at->pose.position += deviation.position;
    at->pose.orientation = at->pose.orientation * Eigen::AngleAxisd(turn.norm(), turn.stableNormalized());
  }
  if (at && matching.lever_arm && truth.has_orientation) {
    move_on_body(inverse(*matching.lever_arm), kFixedAxes, at->pose, at->covariance);
  }
  return at;
}

Eigen::Isometry3d align_truth(const std::vector<SpatialPose>& truth, const std::vector<SpatialPose>& estimate,
                              TruthAlignment alignment) {
  switch (alignment) {
    case TruthAlignment::none: break;
    case TruthAlignment::se2: return align_heading(truth, estimate, false);
    case TruthAlignment::yaw: return align_heading(truth, estimate, true);
    case TruthAlignment::se3: return align_in_space(truth, estimate);
  }
  return Eigen::Isometry3d::Identity();
}

TruthComparison::TruthComparison(const Trajectory& truth, const TrajectoryMatching& matching,
                                 PoseErrorAxes axes, bool joint_covariance, TruthPlacement placement)
    : truth_(truth),
      matching_(matching),
      axes_(axes),
      placement_(std::move(placement)),
      turn_(placement_.motion.linear()),
      layout_(layout_of(axes, truth.has_orientation, joint_covariance)),
      components_(estimated_components(axes).begin(), estimated_components(axes).end()) {
  components_.resize(layout_.states.size());  // without those of the orientation where the truth has none
}

std::optional<UncertainPose> TruthComparison::truth_at(double time_s, const TruthDeviation& deviation) const {
  std::optional<UncertainPose> truth = credence::internal::truth_at(truth_, time_s, matching_, deviation);
  if (!truth) return std::nullopt;
  truth->pose = {placement_.motion * truth->pose.position, turn_ * truth->pose.orientation};
  if (truth_.covariances.empty()) return truth;
  PoseCovariance turn = PoseCovariance::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = placement_.motion.linear();
  truth->covariance =
      transported(turn * truth->covariance * turn.transpose(), truth->pose, kFixedAxes, axes_);
  return truth;
}

bool TruthComparison::compare(const PoseEstimate& estimate, const UncertainPose& truth,
                              std::span<const Index> kept, Step& step) const {
  std::vector<Index> components;
  step.states.clear();
  for (std::size_t i = 0; i < components_.size(); ++i) {
    if (std::ranges::find(kept, components_[i]) == kept.end()) continue;
    components.push_back(components_[i]);
    step.states.push_back(static_cast<Index>(i));
  }
  if (components.empty()) return false;
  step.line = estimate.line;
  step.error = pose_error(estimate.pose, truth.pose, axes_)(components);
  step.P = estimate.covariance(components, components) + truth.covariance(components, components);
  return true;
}

Matrix TruthComparison::frame_jacobian(const PoseEstimate& estimate, const UncertainPose& truth,
                                       const Step& step, const Eigen::Vector3d& centre) const {
  return credence::internal::frame_jacobian(estimate.pose, truth.pose, centre, axes_)(components_of(step),
                                                                                      Eigen::all);
}

std::vector<Index> TruthComparison::components_of(const Step& step) const {
  std::vector<Index> components;
  for (const Index state : step.states) components.push_back(components_[static_cast<std::size_t>(state)]);
  return components;
}

bool TruthComparison::is_uncertain(double time_s, const UncertainPose& truth,
                                   std::span<const TruthDeviation> deviations, const Step& step) const {
  const std::vector<Index> components = components_of(step);
  std::vector<Vector> off;
  for (const TruthDeviation& deviation : deviations)
    off.emplace_back(pose_error(truth_at(time_s, deviation)->pose, truth.pose, axes_)(components));
  return is_any_too_far(off, step.P);
}

bool TruthComparison::used_up(const PoseEstimate& estimate, const UncertainPose& truth,
                              const Step& step) const {
  if (placement_.alignment == TruthAlignment::none || placement_.by_all) return false;
  const Matrix J = frame_jacobian(estimate, truth, step, placement_.centre);
  const Matrix of_frame = J * placement_.covariance * J.transpose();
  const double rounding = 1e-12 * step.P.trace();
  const Matrix room =
      TruthPlacement::kKnown * step.P - of_frame + rounding * Matrix::Identity(step.P.rows(), step.P.cols());
  return Eigen::LLT<Matrix>(room).info() != Eigen::Success;
}

namespace {

/// Times from the first to the last row.
struct TimeSpan {
  double first_s, last_s;

  double duration_s() const { return last_s - first_s; }
  TimeSpan over(double per_second) const { return {first_s / per_second, last_s / per_second}; }
};

TimeSpan span_of(const Trajectory& trajectory) {
  return {trajectory.time_s.front(), trajectory.time_s.back()};
}

/// Below zero by the time between them.
double overlap_s(TimeSpan a, TimeSpan b) {
  return std::min(a.last_s, b.last_s) - std::max(a.first_s, b.first_s);
}

/// The shorter duration over the longer one; 0 where one has none.
double alike(TimeSpan a, TimeSpan b) {
  const double longer = std::max(a.duration_s(), b.duration_s());
  return longer > 0.0 ? std::min(a.duration_s(), b.duration_s()) / longer : 0.0;
}

enum class Most { of_shorter, of_longer };

/// Whether most of the shorter or of the longer one would meet the other, were the times of one in another
/// unit, in which they last no less alike than as they are; empty: it would not.
std::string other_unit(TimeSpan estimates, TimeSpan truth, Most most) {
  constexpr std::pair<double, const char*> kUnits[] = {{1e3, "ms"}, {1e6, "µs"}, {1e9, "ns"}};
  constexpr double kMost = 0.5;
  const double as_written = alike(estimates, truth);
  const auto meet = [&](TimeSpan a, TimeSpan b) {
    const double asked_s = most == Most::of_longer ? std::max(a.duration_s(), b.duration_s())
                                                   : std::min(a.duration_s(), b.duration_s());
    return overlap_s(a, b) >= kMost * asked_s && alike(a, b) >= as_written;
  };
  for (const auto& [per_second, unit] : kUnits) {
    if (meet(estimates, truth.over(per_second)))
      return fmt::format("they would meet were the times of the truth in {}", unit);
    if (meet(estimates.over(per_second), truth))
      return fmt::format("they would meet were the times of the estimates in {}", unit);
  }
  return {};
}

/// What brings two of about the same duration together, whose clocks then differ in their zero; empty: they
/// last unlike.
std::string other_zero(TimeSpan estimates, TimeSpan truth) {
  constexpr double kAlike = 0.9;
  if (alike(estimates, truth) < kAlike) return {};
  const double ahead_s = std::round(1e3 * (truth.first_s - estimates.first_s)) / 1e3;
  return fmt::format(
      "they last about as long: if they are of one drive, their clocks differ by about {0:.15g} s "
      "(--time-offset {0:.15g})",
      ahead_s);
}

}  // namespace

std::string no_seconds(double time_s) {
  constexpr std::pair<double, const char*> kBeyond[] = {{1e17, "ns"}, {1e14, "µs"}, {1e11, "ms"}};
  for (const auto& [beyond, unit] : kBeyond) {
    if (time_s > beyond) {
      return fmt::format("times up to {:.3g} s are perhaps in {}, where seconds are expected", time_s, unit);
    }
  }
  return {};
}

DataError no_truth(const std::filesystem::path& estimate, double first_s, double last_s,
                   const Trajectory& truth, const TrajectoryMatching& matching) {
  const TimeSpan estimates{first_s, last_s}, of_truth = span_of(truth);
  const double offset_s = matching.time_offset_s.value_or(0.0);
  const bool apart = first_s + offset_s >= of_truth.last_s || last_s + offset_s <= of_truth.first_s;
  std::string more =
      apart ? other_unit(estimates, of_truth, Most::of_shorter) : more_of_sparse(truth, matching);
  if (more.empty()) more = no_seconds(last_s);
  if (more.empty() && apart) more = other_zero(estimates, of_truth);
  return {estimate, "",
          fmt::format("no row has a truth at its time in {}: estimates from {:.3f} to {:.3f} s, truth from "
                      "{:.3f} to {:.3f} s, tolerance {} s{}{}",
                      truth.file.string(), first_s, last_s, of_truth.first_s, of_truth.last_s,
                      matching.max_time_difference_s, more.empty() ? "" : "; ", more)};
}

void tell_unmatched(std::int64_t unmatched, std::int64_t rows, double first_s, double last_s,
                    const Trajectory& truth, const TrajectoryMatching& matching, LogSink& sink) {
  sink.unmatched(unmatched);
  constexpr std::int64_t kFew = 20;  // of so many rows one has a truth
  const std::string unit = other_unit({first_s, last_s}, span_of(truth), Most::of_longer);
  if (kFew * (rows - unmatched) <= rows && !unit.empty()) {
    return sink.mistake(fmt::format("Of {} rows {} have no truth at their time; {}.", rows, unmatched, unit));
  }
  constexpr std::int64_t kMany = 4;  // of so many rows one
  const std::string more = more_of_sparse(truth, matching);
  if (more.empty() || kMany * unmatched < rows) return;
  sink.remark(fmt::format("{} of {} rows have no truth at their time; {}.", unmatched, rows, more));
}

TrajectoryErrors trajectory_errors(const Trajectory& estimate, const Trajectory& truth,
                                   const TrajectoryMatching& matching, ConventionCheck* conventions,
                                   LogSink* sink) {
  static constexpr std::array<Index, 6> kAll = {0, 1, 2, 3, 4, 5};
  TrajectoryErrors result;
  result.placement = place_truth(pose_samples(estimate, matching), truth, matching, estimate.axes,
                                 estimate.joint_covariance);
  const TruthComparison comparison(truth, matching, estimate.axes, estimate.joint_covariance,
                                   result.placement);
  result.layout = comparison.layout();
  TruthGaps gaps(truth, matching);
  DistanceTravelled travelled;
  for (std::size_t i = 0; i < estimate.poses.size(); ++i) {
    const double time = estimate.time_s[i];
    const std::optional<UncertainPose> at = comparison.truth_at(time);
    if (!at) {
      ++result.unmatched;
      continue;
    }
    const PoseEstimate row{time, estimate.lines[i], estimate.poses[i], estimate.covariances[i]};
    const double travelled_m = travelled.at(at->pose.position);
    Step step;
    comparison.compare(row, *at, kAll, step);
    if (comparison.used_up(row, *at, step)) {
      ++result.used_up;
      continue;
    }
    if (comparison.is_uncertain(time, *at, gaps.at(time), step)) {
      gaps.leave_out();
      continue;
    }
    step.step = std::ssize(result.rows) + 1;
    result.rows.push_back(std::move(step));
    result.time_s.push_back(time);
    result.travelled_m.push_back(travelled_m);
    if (conventions != nullptr && truth.has_orientation) conventions->add(row, *at);
  }
  if (result.unmatched == std::ssize(estimate.poses))
    throw no_truth(estimate.file, estimate.time_s.front(), estimate.time_s.back(), truth, matching);
  if (conventions != nullptr && sink != nullptr) conventions->tell(comparison, *sink);
  result.between_truths = gaps.left_out();
  if (sink != nullptr) gaps.tell(estimate.file, std::ssize(result.rows), *sink);
  return result;
}

}  // namespace credence::internal
