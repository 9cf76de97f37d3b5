#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/inflation/inflation.h"
#include "core/models/vehicle.h"
#include "core/types.h"

namespace credence::internal {

/// How an observation finds its landmark.
enum class ReplayAssociation {
  survey,         ///< known: by the survey, or by the barcode
  compatibility,  ///< the filter's own: the nearest landmark among those within the gate
};

/// Where F, G and H are taken.
enum class ReplayJacobians {
  estimate,  ///< at the filter's own estimates: the EKF
  truth,     ///< at the true pose and the survey, innovations as ever: what the EKF would be without the
             ///< spurious information of its own linearisation points; needs a true heading (MRCLAM)
};

/// What a sensor calls range.
enum class RangeKind {
  distance,  ///< to the landmark
  depth,     ///< along the axis of the camera: distance × cos(bearing)
};

struct ReplayWorld {
  bool full = false;  ///< `observability`: false "partial", true "full", with anchors
  Index anchors = 1;  ///< the first landmarks seen stand at their surveyed places; of no effect when partial
};

struct ReplayFilterSettings {
  Inflation inflation = Inflation::none;
  InflationSolution solution = InflationSolution::pairwise;
  ReplayAssociation association = ReplayAssociation::survey;
  double gate = 0;  ///< probability of the chi-square gate on each observation, in [0, 1); 0: none
  ReplayJacobians jacobians = ReplayJacobians::estimate;
  std::string estimator = "ekf";  ///< a name of estimator_kinds(); inflation and anchors are of "ekf" alone
};

struct ReplayInitial {
  double position_std = 0.05;   ///< m, of each coordinate
  double heading_std_deg = 2;   ///< degrees
  double heading_deg = -126.6;  ///< car park; MRCLAM starts at the true pose
};

struct ReplayNoise {
  double speed_std = 0.7;       ///< m/s, of each odometry sample, which holds until the next
  double steering_std_deg = 7;  ///< degrees, car park
  double turn_rate_std = 0;     ///< rad/s, MRCLAM
  double range_std = 0.1;       ///< m
  double bearing_std_deg = 1;   ///< degrees
};

/// What is known of the sensors' systematic errors; the filter works with the corrected values.
struct ReplaySensor {
  RangeKind range = RangeKind::distance;
  double range_offset_m = 0;      ///< subtracted from every range, before
  double range_scale = 1;         ///< it is divided by this
  double bearing_offset_deg = 0;  ///< subtracted from every bearing
  double odometry_delay_s = 0;    ///< added to the time of every odometry sample
  double speed_scale = 1;         ///< true over logged speed
  double turn_scale = 1;          ///< true over logged turn rate, MRCLAM
  double turn_drift_deg_s = 0;    ///< added to the scaled turn rate, MRCLAM
};

/// How well the reference itself is known: its variance is added to that of the filter in every NEES of the
/// vehicle.
struct ReplayTruth {
  double position_std = 0.02;  ///< m, of each coordinate
  double heading_std_deg = 0;  ///< degrees, MRCLAM
};

/// What the EKF-SLAM of a replay believes; the fields have the names that `--set` knows, group by group.
///
/// The vehicle is the data set's and cannot be set by name: the car of the car park, the unicycle of MRCLAM.
struct ReplaySettings {
  VehicleKind vehicle = VehicleKind::car;
  ReplayWorld world;
  ReplayFilterSettings filter;
  ReplayInitial initial;
  ReplayNoise noise;
  ReplaySensor sensor;
  ReplayTruth truth;
};

/// ACFR's own tuning of the car park: 0.7 m/s, 7°, 0.10 m, 1°, known association, no gate.
ReplaySettings carpark_settings();

/// The tuning for MRCLAM 7: the camera's depth with its measured offset, scale and noise, the odometry's
/// measured scale and drift of robots 1 and 3 (their mean for any other), odometry noise that covers its
/// errors over a second, and a gate against gross errors. docs/datasets.md says how each was measured.
ReplaySettings mrclam_settings(int robot);

/// Sets one value by its name, e.g. "noise.range_std" to "0.2".
///
/// Throws std::invalid_argument that names key, value and what is accepted, also for a key that means nothing
/// for the vehicle (a steering angle of the unicycle).
void set_replay_setting(ReplaySettings& settings, std::string_view key, std::string_view value);

/// Throws std::invalid_argument for an impossible setting (a negative deviation, a gate of 1, no anchors).
void check_replay_settings(const ReplaySettings& settings);

/// A setting's name and present value as text, as set_replay_setting takes them; in the order of the struct,
/// without those that mean nothing for the vehicle.
struct ReplaySettingText {
  std::string key, value;
};
std::vector<ReplaySettingText> replay_settings_text(const ReplaySettings& settings);

}  // namespace credence::internal
