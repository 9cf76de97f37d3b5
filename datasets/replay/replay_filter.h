#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "datasets/replay/replay_result.h"
#include "datasets/replay/replay_slam.h"

namespace credence::internal {

/// One observation as the log has it: which surveyed landmark it is, −1 if none.
struct LoggedObservation {
  int landmark = -1;
  RangeBearing z;
};

/// How a replay begins.
struct ReplayStart {
  double time_s = 0;
  Pose pose = Pose::Zero();
  std::vector<Point> survey_m;
  std::vector<int> first_seen;  ///< surveyed landmarks by first observation: the first become anchors
  /// The true pose at a time, where it is known; only needed for Jacobians at the truth, which where it is
  /// not known are taken at the last one moved as the control says.
  std::function<std::optional<Pose>(double time_s)> truth = {};
};

/// A SLAM filter fed with the events of a log in order of time; it keeps all that a report shows.
///
/// The order of calls is that of the log: control, advance_to, observe, compare. The control holds between
/// its samples. Standard deviations of the control are those of one sample, so that the noise of an interval
/// depends, as in ACFR's filter, on how often the odometry speaks: variance σ² Σ dt².
class ReplayFilter {
 public:
  /// Throws std::invalid_argument for impossible settings.
  ReplayFilter(const ReplaySettings& settings, const ReplayStart& start);

  /// Predicts to a time with the control that holds; a time that is past does nothing.
  void advance_to(double time_s);

  /// The control that holds from now on.
  void set_control(const Control& u) { control_ = u; }

  /// Uses all observations of one time: gate, inflation, update, initialisation. Advances there first.
  void observe(double time_s, std::span<const LoggedObservation> observations);

  /// Compares the predicted position with a measured one; the filter stays as it is.
  void compare_position(double time_s, const Point& position_m);

  /// Compares the pose with the true one.
  void compare_pose(double time_s, const Pose& truth);

  double time_s() const { return time_s_; }

  /// Closes the replay: final map, its errors, means.
  ReplayResult finish();

 private:
  /// One observation on its way into the filter; `id` is the filter's number of the landmark.
  struct Candidate {
    std::size_t observation = 0;  ///< in result_.records
    int id = -1;
    bool is_new = false;
  };
  struct PosePrediction {
    Pose pose;
    Eigen::Matrix3d P;
  };

  PosePrediction predicted(double time_s) const;
  std::optional<Pose> next_true_pose(double time_s);
  void compare(ReplayReference reference, const Vector& error, const Matrix& covariance);
  void follow_traces();

  std::vector<Candidate> associate_by_survey(std::size_t first);
  std::vector<Candidate> associate_by_compatibility(std::size_t first);
  void judge_pair(ReplayObservation& observation, int id);
  bool is_known(int id) const;
  std::vector<int> known_ids() const;
  RangeBearing corrected(const RangeBearing& z) const;
  bool update(std::span<const Candidate> candidates, double time_s);
  Matrix gain() const;
  void record_step(double time_s);
  std::vector<ReplayLandmark> map_now(const Matrix& K) const;

  ReplaySettings settings_;
  Vehicle vehicle_;
  Eigen::Matrix2d Q_, R_;
  std::vector<int> anchors_;
  std::vector<int> survey_of_;  ///< by the filter's number: which surveyed landmark it is taken for
  std::unique_ptr<ReplaySlam> filter_;
  Control control_ = Control::Zero();
  double time_s_ = 0;
  std::function<std::optional<Pose>(double)> truth_;  ///< empty unless Jacobians are taken there
  Pose true_pose_;                                    ///< the last, if so
  double squared_error_ = 0, squared_heading_error_ = 0;
  Index headings_ = 0;
  ReplayResult result_;
};

}  // namespace credence::internal
