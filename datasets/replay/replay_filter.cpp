#include "datasets/replay/replay_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "core/linear_algebra/cholesky.h"
#include "core/manifold/angle.h"
#include "core/stop_point.h"
#include "datasets/logs/alignment.h"

namespace credence::internal {
namespace {

/// Probability beyond which an observation that fits no landmark is a new one; between the gate and this it
/// is dropped.
constexpr double kNewLandmarkProbability = 0.999999;

Eigen::Matrix2d diagonal(double a, double b) { return Eigen::Vector2d(a * a, b * b).asDiagonal(); }

Eigen::Matrix2d control_noise(const ReplaySettings& settings) {
  const bool steered = settings.vehicle != VehicleKind::unicycle;
  return diagonal(settings.noise.speed_std, steered ? settings.noise.steering_std_deg * kRadiansPerDegree
                                                    : settings.noise.turn_rate_std);
}

std::vector<int> chosen_anchors(const ReplaySettings& settings, const ReplayStart& start) {
  if (!settings.world.full) return {};
  const auto count = std::min(static_cast<std::size_t>(settings.world.anchors), start.first_seen.size());
  return {start.first_seen.begin(), start.first_seen.begin() + static_cast<std::ptrdiff_t>(count)};
}

bool looks_at_truth(const ReplaySettings& settings) {
  return settings.filter.jacobians == ReplayJacobians::truth || settings.filter.estimator == "ideal";
}

std::vector<ReplayAnchor> placed(const std::vector<int>& anchors, const std::vector<Point>& survey_m) {
  std::vector<ReplayAnchor> result;
  result.reserve(anchors.size());
  for (const int anchor : anchors) result.push_back({anchor, survey_m.at(static_cast<std::size_t>(anchor))});
  return result;
}

double position_trace(const Matrix& P) { return P(0, 0) + P(1, 1); }
double landmarks_trace(const Matrix& P) { return P.diagonal().tail(P.rows() - 3).sum(); }

/// Of a position or landmark that starts at `row`; nothing for one that the update of K only added.
ReplayGain gain_of_rows(const Matrix& K, Index row) {
  ReplayGain gain;
  if (row + 2 > K.rows()) return gain;
  for (Index column = 0; column + 1 < K.cols(); column += 2) {
    gain.range += K.block(row, column, 2, 1).squaredNorm();
    gain.bearing += K.block(row, column + 1, 2, 1).squaredNorm();
  }
  return {std::sqrt(gain.range), std::sqrt(gain.bearing)};
}

}  // namespace

ReplayFilter::ReplayFilter(const ReplaySettings& settings, const ReplayStart& start)
    : settings_((check_replay_settings(settings), settings)),
      vehicle_{settings.vehicle, {}},
      Q_(control_noise(settings)),
      R_(diagonal(settings.noise.range_std, settings.noise.bearing_std_deg * kRadiansPerDegree)),
      anchors_(chosen_anchors(settings, start)),
      survey_of_(start.survey_m.size()),
      filter_(make_replay_slam(settings, {vehicle_, Q_, R_, placed(anchors_, start.survey_m), start.survey_m,
                                          settings.filter.jacobians == ReplayJacobians::truth})),
      time_s_(start.time_s),
      true_pose_(start.pose) {
  std::iota(survey_of_.begin(), survey_of_.end(), 0);
  const double position = settings.initial.position_std;
  const double heading = settings.initial.heading_std_deg * kRadiansPerDegree;
  const Eigen::Matrix3d P0 =
      Eigen::Vector3d(position * position, position * position, heading * heading).asDiagonal();
  filter_->reset(start.pose, P0);
  if (looks_at_truth(settings)) {
    if (!start.truth) throw std::invalid_argument("Jacobians at the truth: this log has no true heading");
    truth_ = start.truth;
  }
  result_.settings = settings;
  result_.start_time_s = start.time_s;
  result_.survey_m = start.survey_m;
  result_.anchors = anchors_;
  result_.nis.expected = expected_nis(settings.filter.gate);
  result_.landmark_nees.expected = 2.0;
  follow_traces();
}

std::optional<Pose> ReplayFilter::next_true_pose(double time_s) {
  if (!truth_) return std::nullopt;
  true_pose_ = truth_(time_s).value_or(vehicle_.moved(true_pose_, control_, time_s - time_s_));
  return true_pose_;
}

void ReplayFilter::advance_to(double time_s) {
  if (time_s <= time_s_) return;
  filter_->predict(control_, time_s - time_s_, next_true_pose(time_s));
  time_s_ = time_s;
  follow_traces();
}

void ReplayFilter::follow_traces() {
  ReplayTraces& traces = result_.covariance;
  traces.vehicle_final = position_trace(filter_->covariance());
  traces.landmarks_final = landmarks_trace(filter_->covariance());
  traces.vehicle_max = std::max(traces.vehicle_max, traces.vehicle_final);
  traces.landmarks_max = std::max(traces.landmarks_max, traces.landmarks_final);
}

// ---------------------------------------------------------------------------------------------- association

bool ReplayFilter::is_known(int id) const {
  return filter_->offset_of(id) >= 0 || std::ranges::find(anchors_, id) != anchors_.end();
}

std::vector<int> ReplayFilter::known_ids() const {
  std::vector<int> ids(filter_->landmarks().begin(), filter_->landmarks().end());
  ids.insert(ids.end(), anchors_.begin(), anchors_.end());
  return ids;
}

/// Innovation, S and NIS of an observation if it were landmark `id`.
void ReplayFilter::judge_pair(ReplayObservation& observation, int id) {
  const ReplaySlam::Compatibility found = filter_->judge(observation.z, id);
  observation.innovation = found.innovation;
  observation.S = found.S;
  observation.nis = found.nis;
}

std::vector<ReplayFilter::Candidate> ReplayFilter::associate_by_survey(std::size_t first) {
  const double threshold = gate_threshold(settings_.filter.gate);
  std::vector<Candidate> candidates;
  for (std::size_t i = first; i < result_.records.size(); ++i) {
    ReplayObservation& observation = result_.records[i];
    if (observation.landmark < 0) {
      observation.outcome = ObservationOutcome::unassociated;
      continue;
    }
    const bool known = is_known(observation.landmark);
    if (settings_.filter.gate > 0 && known) {
      for (const int other : known_ids()) {
        ReplayObservation trial = observation;
        judge_pair(trial, other);
        if (other != observation.landmark && trial.nis <= threshold) observation.ambiguous = true;
      }
      judge_pair(observation, observation.landmark);
      if (observation.nis > threshold) {
        observation.outcome = ObservationOutcome::rejected;
        continue;
      }
    }
    candidates.push_back({i, observation.landmark, !known});
  }
  return candidates;
}

/// Individual compatibility with the nearest neighbour: the smallest NIS among the landmarks within the gate.
std::vector<ReplayFilter::Candidate> ReplayFilter::associate_by_compatibility(std::size_t first) {
  const double threshold = gate_threshold(settings_.filter.gate);
  const double new_threshold = gate_threshold(kNewLandmarkProbability);
  std::vector<Candidate> candidates;
  const auto taken = [&](int id) {
    return std::ranges::any_of(candidates, [&](const Candidate& c) { return c.id == id; });
  };
  for (std::size_t i = first; i < result_.records.size(); ++i) {
    ReplayObservation best = result_.records[i];
    best.nis = std::numeric_limits<double>::infinity();
    int best_id = -1, compatible = 0;
    for (const int id : known_ids()) {
      ReplayObservation trial = result_.records[i];
      judge_pair(trial, id);
      if (trial.nis <= threshold) ++compatible;
      if (trial.nis >= best.nis) continue;
      best = trial;
      best_id = id;
    }
    if (best_id < 0 || best.nis > new_threshold) {
      const int own = best.landmark;
      const bool free = own >= 0 && !is_known(own) && !taken(own);
      const int id = free ? own : static_cast<int>(survey_of_.size());
      if (!free) survey_of_.push_back(own);
      candidates.push_back({i, id, true});
      continue;
    }
    best.ambiguous = compatible > 1;
    if (best.nis > threshold || taken(best_id)) {
      best.outcome = ObservationOutcome::rejected;
    } else {
      candidates.push_back({i, best_id, false});
      if (survey_of_[static_cast<std::size_t>(best_id)] != best.landmark) ++result_.mismatched;
    }
    result_.records[i] = best;
  }
  return candidates;
}

// --------------------------------------------------------------------------------------------------- update

RangeBearing ReplayFilter::corrected(const RangeBearing& z) const {
  const ReplaySensor& sensor = settings_.sensor;
  double range_m = (z(0) - sensor.range_offset_m) / sensor.range_scale;
  if (sensor.range == RangeKind::depth) range_m /= std::cos(z(1));
  return {range_m, wrap_angle(z(1) - sensor.bearing_offset_deg * kRadiansPerDegree)};
}

void ReplayFilter::observe(double time_s, std::span<const LoggedObservation> observations) {
  if (observations.empty()) return;
  advance_to(time_s);
  const std::size_t first = result_.records.size();
  for (const LoggedObservation& observation : observations) {
    ReplayObservation record;
    record.time_s = time_s - result_.start_time_s;
    record.landmark = observation.landmark;
    record.z = corrected(observation.z);
    result_.records.push_back(record);
  }
  ++result_.scans_with_observations;

  // The prior that the update will use, so that the gate and the innovations after it speak of the same S.
  if (settings_.filter.gate > 0) filter_->prepare_to_judge();
  std::vector<Candidate> waiting = settings_.filter.association == ReplayAssociation::survey
                                       ? associate_by_survey(first)
                                       : associate_by_compatibility(first);
  // A landmark seen twice at one time, which a batch must not hold, waits for the next batch.
  while (!waiting.empty()) {
    std::vector<Candidate> batch, later;
    for (const Candidate& candidate : waiting) {
      const bool twice = std::ranges::find(batch, candidate.id, &Candidate::id) != batch.end();
      (twice ? later : batch).push_back(candidate);
    }
    if (update(batch, time_s - result_.start_time_s)) record_step(time_s - result_.start_time_s);
    for (Candidate& candidate : later)
      candidate.is_new = !is_known(candidate.id);  // also where the update failed
    waiting = later;
  }
}

/// One batch update; returns whether a measurement corrected the state or a landmark was added.
bool ReplayFilter::update(std::span<const Candidate> candidates, double time_s) {
  stop_point();
  std::vector<Observation<PlanarModel>> observations;
  for (const Candidate& candidate : candidates)
    observations.push_back({candidate.id, result_.records[candidate.observation].z});
  const UpdateResult outcome = filter_->update(observations);
  if (!outcome.converged) ++result_.not_converged;
  if (!outcome.ok) {
    for (const Candidate& c : candidates)
      result_.records[c.observation].outcome = ObservationOutcome::update_failed;
    return false;
  }
  // Whitened together, so that the parts of one batch are uncorrelated too.
  Vector whitened = filter_->innovation();
  Eigen::LLT<Matrix> root;
  if (outcome.dof > 0) root.compute(filter_->innovation_covariance()).matrixL().solveInPlace(whitened);
  Index row = 0;
  for (const Candidate& candidate : candidates) {
    ReplayObservation& observation = result_.records[candidate.observation];
    if (candidate.is_new) {
      observation.outcome = ObservationOutcome::initialised;
      continue;
    }
    observation.outcome = ObservationOutcome::updated;
    observation.innovation = filter_->innovation().segment<2>(row);
    observation.S = filter_->innovation_covariance().block<2, 2>(row, row);
    observation.nis =
        Eigen::LLT<Eigen::Matrix2d>(observation.S).matrixL().solve(observation.innovation).squaredNorm();
    observation.whitened = whitened.segment<2>(row);
    observation.root = root.matrixLLT().block<2, 2>(row, row).triangularView<Eigen::Lower>();
    observation.first_of_batch = row == 0;
    result_.nis.add(observation.nis);
    row += 2;
  }
  if (outcome.dof > 0) result_.updates.push_back({time_s, outcome.nis, outcome.dof});
  follow_traces();
  return true;
}

// K of the last update, nothing where it corrected nothing.
Matrix ReplayFilter::gain() const { return filter_->innovation().size() == 0 ? Matrix() : filter_->gain(); }

std::vector<ReplayLandmark> ReplayFilter::map_now(const Matrix& K) const {
  std::vector<ReplayLandmark> map;
  for (const int id : filter_->landmarks()) {
    const Index offset = filter_->offset_of(id);
    map.push_back({survey_of_[static_cast<std::size_t>(id)], filter_->state().segment<2>(offset),
                   filter_->covariance().block<2, 2>(offset, offset), gain_of_rows(K, offset)});
  }
  return map;
}

void ReplayFilter::record_step(double time_s) {
  const Matrix K = gain();
  result_.steps.push_back(
      {time_s, filter_->pose(), filter_->covariance().topLeftCorner<3, 3>(), gain_of_rows(K, 0), map_now(K)});
}

// ----------------------------------------------------------------------------------------------- comparison

ReplayFilter::PosePrediction ReplayFilter::predicted(double time_s) const {
  const Eigen::Matrix3d P = filter_->covariance().topLeftCorner<3, 3>();
  if (time_s <= time_s_) return {filter_->pose(), P};
  const Motion motion = vehicle_.move(filter_->pose(), control_, time_s - time_s_);
  return {motion.pose, motion.F * P * motion.F.transpose() + motion.G * Q_ * motion.G.transpose()};
}

void ReplayFilter::compare(ReplayReference reference, const Vector& error, const Matrix& covariance) {
  const Eigen::LLT<Matrix> factor(covariance);
  reference.singular = factor.info() != Eigen::Success;
  if (!reference.singular) {
    reference.nees = factor.matrixL().solve(error).squaredNorm();
    result_.vehicle_nees.add(reference.nees);
  }
  result_.vehicle_nees.expected = static_cast<double>(reference.dof);
  squared_error_ += error.head<2>().squaredNorm();
  result_.references.push_back(reference);
}

void ReplayFilter::compare_position(double time_s, const Point& position_m) {
  const PosePrediction now = predicted(time_s);
  const double std_m = settings_.truth.position_std;
  const Eigen::Matrix2d P = now.P.topLeftCorner<2, 2>() + diagonal(std_m, std_m);
  ReplayReference reference;
  reference.time_s = time_s - result_.start_time_s;
  reference.estimate = now.pose;
  reference.covariance = now.P;
  reference.truth << position_m, 0.0;
  reference.dof = 2;
  compare(reference, now.pose.head<2>() - position_m, P);
}

void ReplayFilter::compare_pose(double time_s, const Pose& truth) {
  const PosePrediction now = predicted(time_s);
  ReplayReference reference;
  reference.time_s = time_s - result_.start_time_s;
  reference.estimate = now.pose;
  reference.covariance = now.P;
  reference.truth = truth;
  reference.dof = 3;
  Pose error = now.pose - truth;
  error(2) = wrap_angle(error(2));
  squared_heading_error_ += error(2) * error(2);
  ++headings_;
  Eigen::Matrix3d P = now.P;
  P.topLeftCorner<2, 2>() += diagonal(settings_.truth.position_std, settings_.truth.position_std);
  P(2, 2) += std::pow(settings_.truth.heading_std_deg * kRadiansPerDegree, 2);
  compare(reference, error, P);
}

ReplayResult ReplayFilter::finish() {
  result_.duration_s = time_s_ - result_.start_time_s;
  result_.observations = static_cast<Index>(result_.records.size());
  for (const ReplayObservation& observation : result_.records) {
    if (observation.landmark >= 0) ++result_.associated;
    if (observation.ambiguous) ++result_.ambiguous;
    switch (observation.outcome) {
      case ObservationOutcome::updated: ++result_.updated; break;
      case ObservationOutcome::initialised: ++result_.initialised; break;
      case ObservationOutcome::rejected: ++result_.rejected; break;
      case ObservationOutcome::unassociated: ++result_.unassociated; break;
      case ObservationOutcome::update_failed: ++result_.failed; break;
    }
  }
  if (!result_.references.empty())
    result_.vehicle_rmse = std::sqrt(squared_error_ / static_cast<double>(result_.references.size()));
  if (headings_ > 0)
    result_.heading_rmse_deg =
        std::sqrt(squared_heading_error_ / static_cast<double>(headings_)) / kRadiansPerDegree;

  result_.map = map_now(gain());
  const Index map_size = 2 * static_cast<Index>(result_.map.size());
  result_.map_covariance = filter_->covariance().bottomRightCorner(map_size, map_size);
  std::vector<Point> truth, estimate;
  for (const ReplayLandmark& landmark : result_.map) {
    if (landmark.landmark < 0) continue;
    truth.push_back(result_.survey_m[static_cast<std::size_t>(landmark.landmark)]);
    estimate.push_back(landmark.position);
    const Eigen::LLT<Eigen::Matrix2d> factor(landmark.covariance);
    if (factor.info() == Eigen::Success)
      result_.landmark_nees.add(factor.matrixL().solve(estimate.back() - truth.back()).squaredNorm());
  }
  result_.landmark_rms = rms_distance(truth, estimate);
  result_.landmark_rms_aligned = rms_distance_aligned(truth, estimate);
  return std::move(result_);
}

}  // namespace credence::internal
