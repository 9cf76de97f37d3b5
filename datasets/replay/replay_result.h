#pragma once

#include <string>
#include <vector>

#include "core/models/range_bearing.h"
#include "core/models/vehicle.h"
#include "core/types.h"
#include "datasets/replay/replay_settings.h"

namespace credence::internal {

/// A mean with what a consistent filter would have; no mean without samples.
struct ReplayMean {
  double sum = 0;
  Index count = 0;
  double expected = 0;

  void add(double value) {
    sum += value;
    ++count;
  }
  double mean() const { return count > 0 ? sum / static_cast<double>(count) : 0; }
};

/// What became of one observation of a landmark.
enum class ObservationOutcome {
  updated,        ///< corrected the state
  initialised,    ///< put a new landmark into the state
  rejected,       ///< outside the gate of its landmark; not used
  unassociated,   ///< no surveyed landmark is near; not used
  update_failed,  ///< the innovation covariance was not positive definite; not used
};

/// One observation with its innovation, which is that of the prior after inflation (zero unless updated or
/// rejected).
struct ReplayObservation {
  double time_s = 0;
  int landmark = -1;  ///< from 0, in the survey; −1 if unassociated
  ObservationOutcome outcome = ObservationOutcome::updated;
  bool ambiguous = false;  ///< another landmark of the map was within the gate as well
  RangeBearing z = RangeBearing::Zero();
  RangeBearing innovation = RangeBearing::Zero();
  Eigen::Matrix2d S = Eigen::Matrix2d::Zero();
  double nis = 0;  ///< νᵀ S⁻¹ ν of this observation alone, 2 dof
  RangeBearing whitened =
      RangeBearing::Zero();  ///< its part of L⁻¹ν of the whole batch, S = L Lᵀ; if updated
  Eigen::Matrix2d root = Eigen::Matrix2d::Identity();  ///< its block of L on the diagonal; if updated
  bool first_of_batch = false;  ///< of the observations updated together the first: its gate knows no other

  /// Its part of ln det S of the batch; if updated.
  double log_determinant() const { return 2.0 * root.diagonal().array().log().sum(); }
};

/// One batch update: the statistic whose sum over updates has independent terms under consistency.
struct ReplayUpdate {
  double time_s = 0;
  double nis = 0;
  Index dof = 0;
};

/// How strongly range and bearing innovations move a point: Frobenius norms of the parts of K.
struct ReplayGain {
  double range = 0;    ///< dimensionless
  double bearing = 0;  ///< m/rad
};

/// A landmark of the map at some time.
struct ReplayLandmark {
  int landmark = -1;  ///< from 0, in the survey: which one it is taken for
  Point position;
  Eigen::Matrix2d covariance;
  ReplayGain gain;  ///< of the last update
};

/// The filter after the observations of one time were used.
struct ReplayStep {
  double time_s = 0;
  Pose pose;
  Eigen::Matrix3d covariance;
  ReplayGain gain;  ///< of the vehicle's position
  std::vector<ReplayLandmark> landmarks;
};

/// The filter beside an independent measurement of where the vehicle is.
struct ReplayReference {
  double time_s = 0;
  Pose estimate;
  Eigen::Matrix3d covariance;
  Pose truth;             ///< heading 0 and not used when dof is 2
  Index dof = 2;          ///< 2: position (GPS), 3: pose (motion capture)
  double nees = 0;        ///< of estimate − truth, with the covariance of the reference added
  bool singular = false;  ///< that covariance has no Cholesky factor: no nees, and not in the mean
};

/// Traces of P in m², of the vehicle's position and of all landmarks; max over all events of the log.
struct ReplayTraces {
  double vehicle_max = 0, vehicle_final = 0;
  double landmarks_max = 0, landmarks_final = 0;
};

/// What EKF-SLAM on a log gives: the numbers of `credence replay` and the series for its figures.
///
/// Times are seconds since `start_time_s`.
struct ReplayResult {
  std::string dataset;
  std::string run;  ///< which of its runs, e.g. "robot 1"; empty if there is one
  ReplaySettings settings;
  double start_time_s = 0;
  double duration_s = 0;

  // Every observation has one outcome: observations = updated + initialised + rejected + unassociated +
  // failed.
  Index observations = 0;             ///< observations after extraction, or rows of landmarks
  Index scans_with_observations = 0;  ///< times at which something was seen
  Index associated = 0;               ///< observations that the survey, or the barcode, gives a landmark
  Index updated = 0, initialised = 0, rejected = 0, unassociated = 0, failed = 0;
  Index ambiguous =
      0;  ///< observations with more than one landmark within the gate (whatever became of them)
  Index mismatched =
      0;  ///< with association by compatibility: observations given another landmark than by survey
  Index not_converged = 0;  ///< updates in which an iteration did not settle (UpdateResult)
  Index rows_of_robots = 0, rows_of_unknown_barcodes = 0, rows_before_start = 0;  ///< MRCLAM: not used

  ReplayMean nis;            ///< of one observation, 2 dof: expected 2, or less within a gate (truncated law)
  ReplayMean vehicle_nees;   ///< against GPS (2 dof) or motion capture (3 dof)
  ReplayMean landmark_nees;  ///< of the final map against the survey, 2 dof each

  double vehicle_rmse = 0;          ///< m, position against the reference
  double heading_rmse_deg = 0;      ///< degrees; 0 without a true heading
  Index times_without_truth = 0;    ///< MRCLAM: observations' times at which the motion capture has no pose
  double landmark_rms = 0;          ///< m, final map against the survey
  double landmark_rms_aligned = 0;  ///< m, after the survey was moved rigidly onto the map
  ReplayTraces covariance;

  std::vector<ReplayObservation> records;
  std::vector<ReplayUpdate> updates;
  std::vector<ReplayStep> steps;
  std::vector<ReplayReference> references;
  std::vector<ReplayLandmark> map;  ///< final; anchors are not in it
  Matrix map_covariance;            ///< of all its positions together, 2N×2N, in the order of map
  std::vector<int> anchors;         ///< surveyed landmarks that are no states
  std::vector<Point> survey_m;      ///< all surveyed landmarks
};

/// Whether the reference is a pose, and not the position alone.
bool has_true_heading(const ReplayResult& result);

/// E[ν | ν ≤ g] for 2 dof and a gate of probability p, g = −2 ln(1 − p); 2 without a gate.
double expected_nis(double gate_probability);

/// The 2-dof chi-square quantile, −2 ln(1 − p).
double gate_threshold(double gate_probability);

}  // namespace credence::internal
