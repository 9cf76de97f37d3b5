#include "datasets/logs/ros/ros_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/append_item.h"
#include "core/linear_algebra/symmetry.h"
#include "datasets/data_error.h"
#include "datasets/logs/conventions/convention_check.h"
#include "datasets/logs/conventions/thinned.h"
#include "datasets/logs/distance_travelled.h"
#include "datasets/logs/geodesy.h"
#include "datasets/logs/partial_read.h"
#include "datasets/logs/ros/covariance_sentinels.h"
#include "datasets/logs/ros/mcap.h"
#include "datasets/logs/ros/ros1_bag.h"
#include "datasets/logs/ros/ros2_sqlite.h"
#include "datasets/logs/ros/ros_messages.h"
#include "datasets/logs/time_offset.h"
#include "datasets/logs/truth_gaps.h"
#include "datasets/logs/truth_placement.h"

namespace credence::internal {
namespace {

/// A topic and how often it spoke.
struct TopicSeen {
  RosTopic topic;
  std::int64_t publishers = 0, count = 0;
  double first_s = 0.0, last_s = 0.0;

  const RosPoseType* poses() const {
    return topic.encoding == RosTopic::Encoding::other ? nullptr : ros_pose_type(topic.type);
  }
  bool can_be_estimate() const {
    return poses() != nullptr && poses()->covariance && poses()->has_orientation && !poses()->geodetic;
  }
};

/// The topics of a file. Containers announce one for each of its publishers (connections, channels): those of
/// one name and type are one topic.
class TopicsSeen {
 public:
  void announce(std::size_t number, const RosTopic& topic) {
    const auto same = std::ranges::find(all_, topic, &TopicSeen::topic);
    const auto place = static_cast<std::size_t>(same - all_.begin());
    if (same == all_.end()) all_.push_back({topic});
    ++all_[place].publishers;
    places_.resize(std::max(places_.size(), number + 1));
    places_[number] = place;
  }
  /// The topic of a message, which is counted.
  TopicSeen& spoke(std::size_t number, double time_s) {
    TopicSeen& seen = all_[places_[number]];
    if (seen.count++ == 0) seen.first_s = time_s;
    seen.last_s = time_s;
    return seen;
  }
  std::size_t place(std::size_t number) const { return places_[number]; }
  const std::vector<TopicSeen>& all() const { return all_; }

 private:
  std::vector<TopicSeen> all_;
  std::vector<std::size_t> places_;  ///< of what was announced, by its number
};

/// "/odom (nav_msgs/Odometry, 3952 messages), …" of those that fit; "none" where none does.
template <class Fits>
std::string listed(const std::vector<TopicSeen>& topics, Fits fits) {
  std::string text;
  for (const TopicSeen& seen : topics) {
    if (!fits(seen)) continue;
    append_item(text,
                fmt::format("{} ({}, {})", seen.topic.name, seen.topic.type, counted(seen.count, "message")));
  }
  return text.empty() ? "none" : text;
}

/// "1 message has", "4 messages have".
std::string counted_have(std::int64_t messages) {
  return counted(messages, "message") + (messages == 1 ? " has" : " have");
}

/// "TOPIC" or, of transforms, "TOPIC:CHILD_FRAME".
struct TopicChoice {
  std::string name, child_frame;

  explicit TopicChoice(const std::string& argument)
      : name(argument.substr(0, argument.find(':'))),
        child_frame(name.size() < argument.size() ? argument.substr(name.size() + 1) : "") {}
};

/// Poses of one topic whose times increase.
class PoseStream {
 public:
  PoseStream(std::string topic, std::string child_frame)
      : topic_(std::move(topic)), child_frame_(std::move(child_frame)) {}

  /// Calls `take` with each pose of the message that can be used.
  template <class Take>
  void read(const TopicSeen& seen, double log_time_s, const ByteCursor& message, Take take) {
    read_ros_poses(*seen.poses(), seen.topic.encoding, log_time_s, message, poses_);
    for (const RosPose& pose : poses_) {
      ++messages_;
      if (seen.poses()->several && !child_frame_.empty() && pose.child_frame != child_frame_) continue;
      if (seen.poses()->several) children_.insert(pose.child_frame);
      if (!pose.pose.position.allFinite()) {
        ++not_finite_;
        continue;
      }
      if (used_ > 0 && !(pose.time_s > last_s_)) {
        ++not_later_;
        continue;
      }
      if (used_++ == 0) first_s_ = pose.time_s;
      last_s_ = pose.time_s;
      frame_ = pose.frame;
      if (seen.poses()->has_orientation && !pose.has_orientation) ++without_orientation_;
      take(pose, messages_);
    }
  }

  void tell(LogSink& sink) const {
    if (not_later_ > 0) {
      sink.remark(fmt::format("{}: {} with a time no later than the one before {} left out.", topic_,
                              counted(not_later_, "message"), not_later_ == 1 ? "is" : "are"));
    }
    if (not_finite_ > 0) {
      sink.remark(fmt::format("{}: {} without a fix, or with a position that is not finite, {} left out.",
                              topic_, counted(not_finite_, "message"), not_finite_ == 1 ? "is" : "are"));
    }
  }

  /// Of those that were used.
  std::int64_t without_orientation() const { return without_orientation_; }
  const std::string& frame() const { return frame_; }
  const std::set<std::string>& children() const { return children_; }
  double first_s() const { return first_s_; }
  double last_s() const { return last_s_; }

 private:
  std::string topic_, child_frame_, frame_;
  std::set<std::string> children_;
  std::vector<RosPose> poses_;
  std::int64_t messages_ = 0, used_ = 0, not_later_ = 0, not_finite_ = 0, without_orientation_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0;
};

/// Appends truths to a trajectory; places on the earth become east, north and up of the first one.
class TruthBuilder {
 public:
  /// The type of the messages so far; null before the first.
  const RosPoseType* type() const { return type_; }

  /// Messages of one type; the poses of a second one may say other things.
  void add(const RosPoseType& type, const RosPose& pose, std::int64_t message) {
    type_ = &type;
    if (trajectory_.time_s.empty()) {
      trajectory_.axes = kFixedAxes;
      origin_ = pose.pose.position;
    }
    SpatialPose place = pose.pose;
    if (type.geodetic) {
      place.position = east_north_up(origin_) * (earth_fixed(place.position) - earth_fixed(origin_));
    }
    oriented_.push_back(pose.has_orientation);
    trajectory_.time_s.push_back(pose.time_s);
    trajectory_.lines.push_back(message);
    trajectory_.poses.push_back(place);
    if (!type.covariance) return;
    PoseCovariance P = PoseCovariance::Zero();
    if (pose.covariance) {
      // What the truth does not know of itself is taken as exact; an honest truth has no such components.
      const std::vector<Index> kept = sentinels_.kept(*pose.covariance, place);
      P(kept, kept) = (*pose.covariance)(kept, kept);
      with_covariance_ = with_covariance_ || !kept.empty();
    }
    trajectory_.covariances.push_back(P);
  }

  /// Of positions alone where none has an orientation, else without those that have none.
  Trajectory take(const std::filesystem::path& file) {
    trajectory_.file = file;
    if (!with_covariance_) trajectory_.covariances.clear();
    trajectory_.has_orientation = std::ranges::find(oriented_, true) != oriented_.end();
    if (trajectory_.has_orientation) {
      keep_oriented(trajectory_.time_s);
      keep_oriented(trajectory_.lines);
      keep_oriented(trajectory_.poses);
      keep_oriented(trajectory_.covariances);
    }
    return std::move(trajectory_);
  }

 private:
  template <class T>
  void keep_oriented(std::vector<T>& rows) const {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (oriented_[i]) rows[kept++] = rows[i];
    }
    rows.resize(kept);
  }

  const RosPoseType* type_ = nullptr;
  Trajectory trajectory_;
  CovarianceSentinels sentinels_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<bool> oriented_;  ///< of each pose
  bool with_covariance_ = false;
};

/// One file, read in passes.
class RosLog {
 public:
  RosLog(const std::filesystem::path& file, const RosScan& scan, const LogReading& options, LogSink& sink)
      : file_(file),
        scan_(scan),
        options_(options),
        sink_(sink),
        matching_(options.matching),
        truth_choice_(options.truth_topic) {}

  void judge() {
    first_pass();
    choose_estimate();
    if (options_.truth_topic.empty() && options_.truth.empty()) return look_at_covariance();
    const PosesWithTruth poses = with_truth();
    matching_ = with_time_offset(poses, options_, sink_);
    placement_ = place_truth(poses.samples, *poses.truth, matching_, chart().axes, true);
    const TruthComparison comparison(*poses.truth, matching_, chart().axes, true, placement_);
    compare(*poses.truth, comparison);
  }

  PosesWithTruth poses() {
    first_pass();
    choose_estimate();
    return with_truth();
  }

 private:
  PoseChart chart() const { return options_.chart.value_or(pose_chart_of(OrientationError::world)); }

  /// Whether the error of a position and its P can be told without an orientation.
  bool position_needs_no_turn() const { return !to_point_ && chart().axes.position == PositionError::world; }

  PosesWithTruth with_truth() {
    const auto truth =
        options_.truth.empty() ? std::make_shared<const Trajectory>(topic_truth()) : options_.truth.of(file_);
    to_point_ = options_.matching.lever_arm && !truth->has_orientation;
    return {pose_samples(), truth, chart().axes};
  }

  /// Reads topics, and the truth where it is a topic.
  void first_pass() {
    if (!options_.truth_topic.empty() && !options_.truth.empty()) {
      throw std::invalid_argument("--truth and --truth-topic: name one of them");
    }
    const RosVisitor visitor{
        .topic = [&](std::size_t i, const RosTopic& topic) { topics_.announce(i, topic); },
        .message =
            [&](std::size_t i, double time_s, const ByteCursor& message) {
              const TopicSeen& seen = topics_.spoke(i, time_s);
              if (seen.topic.name != truth_choice_.name || seen.poses() == nullptr) return;
              truth_stream_.read(seen, time_s, message, [&](const RosPose& pose, std::int64_t number) {
                add_truth(*seen.poses(), pose, number);
              });
            },
        .advance = [&](std::int64_t bytes) { sink_.advance(bytes); }};
    whole_ = read_part(
        options_, sink_, [&] { scan_(file_, visitor); }, [&] { return !topics_.all().empty(); });
  }

  void add_truth(const RosPoseType& type, const RosPose& pose, std::int64_t number) {
    if (const RosPoseType* first = truth_.type(); first != nullptr && first != &type) {
      throw std::invalid_argument(fmt::format("{}: --truth-topic {}: messages of two types, {} and {}",
                                              file_.string(), options_.truth_topic, first->type, type.type));
    }
    truth_.add(type, pose, number);
  }

  void choose_estimate() {
    const auto fits = [&](const TopicSeen& seen) {
      return seen.can_be_estimate() && seen.topic.name != truth_choice_.name;
    };
    const std::vector<TopicSeen>& topics = topics_.all();
    const std::string all = listed(topics, fits);
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < topics.size(); ++i) {
      if (fits(topics[i]) && (options_.topic.empty() || topics[i].topic.name == options_.topic)) {
        candidates.push_back(i);
      }
    }
    if (candidates.size() == 1) {
      estimate_ = candidates.front();
      return;
    }
    if (!options_.topic.empty()) {
      throw std::invalid_argument(
          fmt::format("{}: --topic {}: it holds no poses with covariance under this name; there are: {}",
                      file_.string(), options_.topic, all));
    }
    if (candidates.empty()) {
      throw DataError(file_, "",
                      fmt::format("holds no poses with covariance (nav_msgs/Odometry or "
                                  "geometry_msgs/PoseWithCovarianceStamped); its topics are: {}",
                                  listed(topics, [](const TopicSeen&) { return true; })));
    }
    throw std::invalid_argument(fmt::format(
        "{}: several topics hold poses with covariance; name one by --topic: {}", file_.string(), all));
  }

  const TopicSeen& estimate() const { return topics_.all()[estimate_]; }

  std::string could_be_truth() const {
    return listed(topics_.all(),
                  [&](const TopicSeen& seen) { return seen.poses() != nullptr && &seen != &estimate(); });
  }

  Trajectory topic_truth() {
    Trajectory truth = truth_.take(file_);
    if (truth.poses.empty()) {
      throw std::invalid_argument(
          fmt::format("{}: --truth-topic {}: no poses of this name are there; there are: {}", file_.string(),
                      options_.truth_topic, could_be_truth()));
    }
    if (truth_stream_.children().size() > 1) {
      throw std::invalid_argument(fmt::format(
          "{}: --truth-topic {}: transforms of several frames; name one as {}:FRAME, of {}", file_.string(),
          options_.truth_topic, truth_choice_.name, fmt::join(truth_stream_.children(), ", ")));
    }
    truth_stream_.tell(sink_);
    if (const std::int64_t none = truth_stream_.without_orientation(); none > 0) {
      sink_.remark(fmt::format("{}: {} a quaternion of zeros, which is no orientation: {}.",
                               options_.truth_topic, counted_have(none),
                               truth.has_orientation ? "left out" : "positions alone are compared"));
    }
    for (const TopicSeen& seen : topics_.all()) {
      // Every broadcaster of transforms has one of its own.
      const bool transforms = seen.poses() != nullptr && seen.poses()->several;
      if (seen.topic.name == truth_choice_.name && !transforms) tell_publishers(seen);
    }
    if (!truth.covariances.empty()) {
      sink_.remark(fmt::format("{}: the truth has a covariance of its own, which is added to P.",
                               options_.truth_topic));
    }
    return truth;
  }

  /// Calls `take` with every estimate and its number.
  template <class Take>
  PoseStream read_estimates(Take take) const {
    PoseStream stream(estimate().topic.name, "");
    const RosVisitor visitor{.message = [&](std::size_t i, double time_s, const ByteCursor& message) {
      if (topics_.place(i) != estimate_) return;
      stream.read(estimate(), time_s, message, take);
    }};
    try {
      scan_(file_, visitor);
    } catch (const DataError&) {
      if (whole_) throw;  // else it is where the first pass ended
    }
    return stream;
  }

  /// What a message says, the components that are estimated, and all of it at the truth's point where that
  /// has no orientation (--lever-arm).
  EstimateSample sample(const RosPose& pose, std::int64_t number, CovarianceSentinels& sentinels) const {
    EstimateSample result{{pose.time_s, number, pose.pose, chart().position_first(*pose.covariance)}, {}};
    PoseEstimate& estimate = result.estimate;
    result.kept = sentinels.kept(estimate.covariance, pose.pose);
    if (!pose.has_orientation) {
      std::erase_if(result.kept, [&](Index i) { return i >= 3 || !position_needs_no_turn(); });
    }
    if (!to_point_) return result;
    // What is not estimated would spread over the position.
    const PoseCovariance all = std::exchange(estimate.covariance, PoseCovariance::Zero());
    estimate.covariance(result.kept, result.kept) = all(result.kept, result.kept);
    move_on_body(*matching_.lever_arm, chart().axes, estimate.pose, estimate.covariance);
    return result;
  }

  /// For the time offset and the place of the truth, if they are asked for; at most 4096.
  std::vector<EstimateSample> pose_samples() const {
    std::vector<EstimateSample> samples;
    if (!is_fitted(matching_)) return samples;
    CovarianceSentinels sentinels;
    std::size_t stride = 1, seen = 0;
    read_estimates([&](const RosPose& pose, std::int64_t number) {
      if (keep_thinned(samples, stride, seen)) samples.push_back(sample(pose, number, sentinels));
    });
    return samples;
  }

  void compare(const Trajectory& truth, const TruthComparison& comparison) {
    CovarianceSentinels sentinels;
    ConventionCheck conventions(chart(), options_.chart.has_value());
    std::int64_t steps = 0, unmatched = 0, without = 0, used_up = 0;
    bool turn_known = true;
    TruthGaps gaps(truth, matching_);
    DistanceTravelled travelled;
    sink_.begin_run(comparison.layout());
    Step step;
    const PoseStream stream = read_estimates([&](const RosPose& pose, std::int64_t number) {
      const std::optional<UncertainPose> at = comparison.truth_at(pose.time_s);
      if (!at) {
        ++unmatched;
        return;
      }
      const double distance_m = travelled.at(at->pose.position);
      const auto [estimate, kept] = sample(pose, number, sentinels);
      if (!comparison.compare(estimate, *at, kept, step)) {
        ++without;
        return;
      }
      if (comparison.used_up(estimate, *at, step)) {
        ++used_up;
        return;
      }
      if (comparison.is_uncertain(pose.time_s, *at, gaps.at(pose.time_s), step)) {
        gaps.leave_out();
        return;
      }
      step.problem = is_symmetric(estimate.covariance(kept, kept), kMostAsymmetry)
                         ? ""
                         : "a covariance is not symmetric";
      turn_known = turn_known && std::ranges::count_if(kept, [](Index i) { return i >= 3; }) > 0;
      step.step = ++steps;
      sink_.travelled(distance_m);
      sink_.at(pose.time_s);
      sink_.add(step);
      if (truth.has_orientation && conventions.takes(kept) && step.problem.empty()) {
        conventions.add(estimate, *at);
      }
    });
    gaps.tell(file_, steps + without + used_up, sink_);
    if (steps == 0 && without == 0 && used_up == 0) {
      throw no_truth(file_, stream.first_s(), stream.last_s(), truth, matching_);
    }
    tell_unmatched(unmatched, steps + without + used_up + unmatched + gaps.left_out(), stream.first_s(),
                   stream.last_s(), truth, matching_, sink_);
    sink_.unmatched(gaps.left_out());
    tell_placement(placement_, used_up, sink_);
    if (steps == 0 && !truth.covariances.empty()) {
      sink_.remark(
          fmt::format("{} has no covariance in any row, the truth has one: are estimate and truth swapped?",
                      estimate().topic.name));
    }
    conventions.tell(comparison, sink_);
    if (to_point_ && !turn_known) {
      sink_.remark(fmt::format(
          "{}: the orientation is not estimated in every row: the lever arm is turned by it as if "
          "it were known exactly.",
          estimate().topic.name));
    }
    tell(stream, sentinels, without);
  }

  void tell_publishers(const TopicSeen& seen) {
    if (seen.publishers < 2) return;
    sink_.remark(fmt::format("{}: {} publishers (connections) wrote to this topic: read as one series.",
                             seen.topic.name, seen.publishers));
  }

  void tell(const PoseStream& stream, const CovarianceSentinels& sentinels, std::int64_t without) {
    const std::string& name = estimate().topic.name;
    stream.tell(sink_);
    if (const std::int64_t none = stream.without_orientation(); none > 0) {
      sink_.remark(fmt::format("{}: {} a quaternion of zeros, which is no orientation: {} is judged there.",
                               name, counted_have(none),
                               position_needs_no_turn() ? "the position alone" : "nothing"));
    }
    tell_publishers(estimate());
    for (std::string& sentence : sentinels.remarks(name)) sink_.remark(std::move(sentence));
    const bool has_truth = !options_.truth_topic.empty() || !options_.truth.empty();
    if (has_truth && sentinels.planar() && chart().axes.orientation != OrientationError::planar) {
      sink_.remark(fmt::format(
          "{}: only x, y and yaw are estimated: with --chart planar it is also told where P lies and what "
          "would mend it.",
          name));
    }
    if (without > 0) {
      sink_.remark(fmt::format("{}: {} {} nothing that is judged.", name, counted(without, "row"),
                               without == 1 ? "estimates" : "estimate"));
    }
    const std::string& truth_frame = truth_stream_.frame();
    if (!truth_frame.empty() && truth_frame != stream.frame() &&
        matching_.alignment == TruthAlignment::none) {
      sink_.remark(fmt::format(
          "The estimate is in the frame '{}', the truth in '{}': nothing was done about it; --align "
          "moves the truth onto the estimate.",
          stream.frame(), truth_frame));
    }
  }

  /// Without a truth: what the numbers of P say by themselves.
  void look_at_covariance() {
    RunLayout layout;
    layout.has_truth = false;
    sink_.begin_run(layout);
    CovarianceSentinels sentinels;
    Step step;
    const PoseStream stream = read_estimates([&](const RosPose& pose, std::int64_t number) {
      sentinels.kept(*pose.covariance, pose.pose);
      ++step.step;
      step.line = number;
      sink_.add(step);
    });
    tell(stream, sentinels, 0);
    const std::string others = could_be_truth();
    sink_.remark(fmt::format(
        "Whether the covariance of {} fits its errors cannot be known from this log: that takes a truth, and "
        "none is named. Name a file by --truth{}.",
        estimate().topic.name,
        others == "none" ? "; the log itself holds no other poses"
                         : ", or by --truth-topic, if it is, " + others));
  }

  std::filesystem::path file_;
  const RosScan& scan_;
  const LogReading& options_;
  LogSink& sink_;
  TrajectoryMatching matching_;
  TruthPlacement placement_;
  bool to_point_ = false;  ///< the truth is a point on the body, beside its frame
  TopicChoice truth_choice_;
  TopicsSeen topics_;
  std::size_t estimate_ = 0;
  bool whole_ = true;  ///< the first pass came to the end of the file
  PoseStream truth_stream_{options_.truth_topic, truth_choice_.child_frame};
  TruthBuilder truth_;
};

LogContents list_topics(const std::filesystem::path& file, const RosScan& scan) {
  TopicsSeen topics;
  const RosVisitor visitor{
      .topic = [&](std::size_t i, const RosTopic& topic) { topics.announce(i, topic); },
      .message = [&](std::size_t i, double time_s, const ByteCursor&) { topics.spoke(i, time_s); }};
  scan(file, visitor);
  LogContents contents;
  for (const TopicSeen& seen : topics.all()) {
    contents.topics.push_back({.name = seen.topic.name,
                               .type = seen.topic.type,
                               .count = seen.count,
                               .rate_hz = message_rate(seen.count, seen.first_s, seen.last_s),
                               .use = seen.can_be_estimate()    ? "estimate, truth"
                                      : seen.poses() != nullptr ? "truth"
                                                                : "",
                               .covariance = seen.poses() != nullptr && seen.poses()->covariance});
  }
  return contents;
}

LogFormat format_of(std::string_view name, std::string_view title, std::string_view extensions,
                    bool (*begins)(std::string_view), const RosScan& scan) {
  return {.name = name,
          .title = title,
          .extensions = extensions,
          .takes_truth = true,
          .has_poses = true,
          .has_topics = true,
          .holds_truth = true,
          .recognises = [begins](std::string_view beginning,
                                 const std::filesystem::path&) { return begins(beginning); },
          .list = [scan](const std::filesystem::path& file) { return list_topics(file, scan); },
          .poses =
              [scan](const std::filesystem::path& file, const LogReading& options) {
                SilentSink sink;
                return RosLog(file, scan, options, sink).poses();
              },
          .read = [scan](const std::filesystem::path& file, const LogReading& options,
                         LogSink& sink) { RosLog(file, scan, options, sink).judge(); }};
}

}  // namespace

LogFormat mcap_format() { return format_of("mcap", "ROS 2 bag, MCAP", ".mcap", begins_as_mcap, scan_mcap); }

LogFormat ros2_sqlite_format() {
  return format_of("db3", "ROS 2 bag, SQLite", ".db3", begins_as_sqlite, scan_ros2_sqlite);
}

LogFormat ros1_bag_format() {
  return format_of("rosbag", "ROS 1 bag", ".bag", begins_as_ros1_bag, scan_ros1_bag);
}

}  // namespace credence::internal
