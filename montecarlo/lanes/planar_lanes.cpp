#include "montecarlo/lanes/planar_lanes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/filters/nees_along_run.h"
#include "core/linear_algebra/logarithm.h"
#include "core/manifold/angle.h"
#include "core/manifold/trigonometry.h"
#include "core/simd/kernel_choice.h"
#include "montecarlo/worlds/slam_layout.h"

namespace credence::internal {
namespace {

constexpr Index kMostBelow = 4;  ///< rows below L: the error, and three to normalise the map with

}  // namespace

const PlanarLanesKernel& planar_lanes_kernel(InstructionSet set) {
  return require_kernel(set, CREDENCE_KERNELS(planar_lanes_kernel));
}

PlanarLanes::PlanarLanes(const PlanarWorld& world, const Eigen::Matrix2d& Q,
                         const RangeBearing& measurement_variance, bool inflate_map, InstructionSet set)
    : world_(world),
      model_{.vehicle = world.vehicle, .dt_s = world.dt_s},
      Q_(Q),
      variance_(measurement_variance),
      inflate_map_(inflate_map),
      kernel_(planar_lanes_kernel(set)),
      states_(3 + 2 * world.states()),
      padded_((states_ + 3) / 4 * 4),
      x_(at(padded_)),
      P_(at(padded_ * padded_)),
      known_(world.landmarks.size()),
      visible_(world.landmarks.size()),
      used_(world.landmarks.size()),
      z_(2 * world.landmarks.size()),
      anchors_(at(2 * world.anchors)),
      offset_(world.landmarks.size()),
      place_(world.landmarks.size()),
      difference_(3 * world.landmarks.size()),
      direction_(world.landmarks.size()),
      H_(10 * world.landmarks.size()),
      R_(2 * world.landmarks.size()),
      nu_(2 * world.landmarks.size()),
      innovation_covariance_(3 * world.landmarks.size()),
      A_(2 * world.landmarks.size() * (2 * world.landmarks.size() + at(padded_) + 1)),
      F_(9),
      GQG_(6),
      error_(at(padded_)),
      whitened_error_(at(padded_)),
      diagonal_(at(padded_)),
      L_(at(padded_ * (padded_ + kMostBelow))),
      columns_(8 * world.landmarks.size()),
      landmark_nees_(at(padded_ / 2)),
      nees_along_run_(states_, std::ssize(world.landmarks), set),
      predicted_(3),
      prior_(3) {
  initialised_.reserve(world.landmarks.size() * kLanes);
  of_measured_.reserve(world.landmarks.size());
  for (Index a = 0; a < world.anchors; ++a) {
    const std::size_t number = at(world.states() + a);
    known_[number] = kAllLanes;
    for (int lane = 0; lane < kLanes; ++lane) {
      for (Index c = 0; c < 2; ++c) anchors_[at(2 * a + c)][lane] = world.landmarks[number][c];
    }
  }
}

void PlanarLanes::reset(int lane, const Pose& pose, const Eigen::Matrix3d& P) {
  for (Lanes& x : x_) x[lane] = 0.0;
  for (Lanes& p : P_) p[lane] = 0.0;
  for (Index i = 0; i < 3; ++i) {
    x_[at(i)][lane] = pose[i];
    for (Index j = 0; j <= i; ++j) covariance_at(i, j)[lane] = P(i, j);
  }
  for (Index l = 0; l < world_.states(); ++l) known_[at(l)] = without(known_[at(l)], lane);
  count_[static_cast<std::size_t>(lane)] = 0;
  steps_[static_cast<std::size_t>(lane)] = {};
  measured_ = 0;
  nees_along_run_.reset(lane, P);
  lost_ = without(lost_, lane);
}

PlanarLanesData PlanarLanes::kernel_data() {
  return {.states = states_,
          .padded = padded_,
          .x = data(x_),
          .P = data(P_),
          .measured = measured_,
          .offset = offset_.data(),
          .place = place_.data(),
          .difference = data(difference_),
          .H = data(H_),
          .R = data(R_),
          .nu = data(nu_),
          .innovation_covariance = data(innovation_covariance_),
          .A = data(A_),
          .nis = nis_.of,
          .check = check_.of,
          .columns = data(columns_),
          .share = share_.of,
          .doubt = doubt_of_S_.of};
}

void PlanarLanes::predict(const Control& u) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const Motion motion = model_.move({x_[0][lane], x_[1][lane], x_[2][lane]}, u);
    const Eigen::Matrix3d GQG = motion.G * Q_ * motion.G.transpose();
    for (Index i = 0, q = 0; i < 3; ++i) {
      x_[at(i)][lane] = motion.pose[i];
      for (Index j = 0; j < 3; ++j) F_[at(3 * i + j)][lane] = motion.F(i, j);
      for (Index j = 0; j <= i; ++j, ++q) GQG_[at(q)][lane] = GQG(i, j);
    }
  }
  kernel_.predict(kernel_data(), data(F_), data(GQG_));
  if (!inflate_map_) nees_along_run_.move(data(F_), data(GQG_));
  std::copy_n(x_.begin(), 3, predicted_.begin());
}

/// Sorts what the lanes see by landmark: a column for each that some lane sees and knows.
void PlanarLanes::take(const std::array<Observations, kLanes>& seen) {
  visible_.assign(visible_.size(), 0);
  for (int lane = 0; lane < kLanes; ++lane) {
    for (const Observation<PlanarModel>& o : seen[static_cast<std::size_t>(lane)]) {
      const Index i = o.landmark;
      visible_[at(i)] = with(visible_[at(i)], lane);
      z_[at(2 * i)][lane] = o.z[0];
      z_[at(2 * i + 1)][lane] = o.z[1];
    }
  }
  of_measured_.clear();
  for (Index i = 0; i < static_cast<Index>(visible_.size()); ++i) {
    const auto used = static_cast<LaneSet>(visible_[at(i)] & known_[at(i)]);
    if (used == 0) continue;
    const std::size_t b = of_measured_.size();
    const bool anchor = i >= world_.states();
    used_[b] = used;
    offset_[b] = anchor ? -1 : 3 + 2 * i;
    place_[b] = anchor ? anchors_[at(2 * (i - world_.states()))].of : x_[at(3 + 2 * i)].of;
    of_measured_.push_back(i);
  }
  measured_ = static_cast<Index>(of_measured_.size());
}

void PlanarLanes::set_innovations() {
  for (std::size_t b = 0; b < at(measured_); ++b) {
    arc_tangents(difference_[3 * b + 1].of, difference_[3 * b].of, direction_[b].of, kLanes);
  }
  for (Index b = 0; b < measured_; ++b) {
    const Index i = of_measured_[at(b)];
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!has(used_[at(b)], lane)) {
        for (Index h = 0; h < 10; ++h) H_[at(10 * b + h)][lane] = 0.0;
        for (Index c = 0; c < 2; ++c) {
          nu_[at(2 * b + c)][lane] = 0.0;
          R_[at(2 * b + c)][lane] = 1.0;
        }
        continue;
      }
      const RangeBearing expected(difference_[at(3 * b + 2)][lane],
                                  wrap_angle(direction_[at(b)][lane] - x_[2][lane]));
      const RangeBearing nu =
          range_bearing_innovation({z_[at(2 * i)][lane], z_[at(2 * i + 1)][lane]}, expected);
      for (Index c = 0; c < 2; ++c) {
        nu_[at(2 * b + c)][lane] = nu[c];
        R_[at(2 * b + c)][lane] = variance_[c];
      }
      steps_[static_cast<std::size_t>(lane)].update.dof += 2;
    }
  }
}

/// Where S has no Cholesky factor nothing is changed.
void PlanarLanes::drop_failed_lanes() {
  for (int lane = 0; lane < kLanes; ++lane) {
    if (check_[lane] == 0.0) continue;
    UpdateResult& result = steps_[static_cast<std::size_t>(lane)].update;
    result.ok = result.dof == 0;
    for (Lanes& a : A_) a[lane] = 0.0;
  }
}

void PlanarLanes::update(const std::array<Observations, kLanes>& seen) {
  if (inflate_map_) {
    kernel_.decorrelate(kernel_data());
    nees_along_run_.start(kernel_data());
  }
  initialised_.clear();
  for (int lane = 0; lane < kLanes; ++lane) {
    UpdateResult& result = steps_[static_cast<std::size_t>(lane)].update;
    result = {};
    for (Index i = 0; i < states_; ++i) result.trace_prior += covariance_at(i, i)[lane];
  }
  take(seen);
  if (measured_ > 0) {
    kernel_.linearise(kernel_data());
    set_innovations();
    kernel_.innovate(kernel_data());
    drop_failed_lanes();
    kernel_.correct(kernel_data());
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    UpdateResult& result = steps_[static_cast<std::size_t>(lane)].update;
    if (!result.ok) continue;
    if (result.dof > 0) {
      result.nis = nis_[lane];
      x_[2][lane] = wrap_angle(x_[2][lane]);
    }
    for (const Observation<PlanarModel>& o : seen[static_cast<std::size_t>(lane)]) {
      if (has(known_[at(o.landmark)], lane)) continue;
      initialise(lane, o.landmark, o.z);
      ++result.initialised;
    }
  }
}

/// P_lx = J_r P_rx, P_ll = J_r P_rr J_rᵀ + J_z R J_zᵀ.
void PlanarLanes::initialise(int lane, Index landmark, const RangeBearing& z) {
  const Index l = 3 + 2 * landmark;
  const PlacedLandmark placed = model_.place({x_[0][lane], x_[1][lane], x_[2][lane]}, z);
  Eigen::Matrix3d P_rr;
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) P_rr(i, j) = covariance_at(i, j)[lane];
  }
  for (Index j = 0; j < states_; ++j) {
    if (j == l || j == l + 1) continue;
    const Eigen::Vector3d P_rj(covariance_at(0, j)[lane], covariance_at(1, j)[lane],
                               covariance_at(2, j)[lane]);
    const Eigen::Vector2d P_lj = placed.J_r * P_rj;
    for (Index c = 0; c < 2; ++c) covariance_at(l + c, j)[lane] = P_lj[c];
  }
  const Eigen::Matrix2d noise = placed.J_z * variance_.asDiagonal() * placed.J_z.transpose();
  const Eigen::Matrix2d own = placed.J_r * P_rr * placed.J_r.transpose() + noise;
  initialised_.push_back({lane, l, placed.J_r, noise});
  covariance_at(l, l)[lane] = own(0, 0);
  covariance_at(l + 1, l)[lane] = 0.5 * (own(0, 1) + own(1, 0));
  covariance_at(l + 1, l + 1)[lane] = own(1, 1);
  for (Index c = 0; c < 2; ++c) x_[at(l + c)][lane] = placed.position[c];
  known_[at(landmark)] = with(known_[at(landmark)], lane);
  ++count_[static_cast<std::size_t>(lane)];
}

void PlanarLanes::compute_errors(const std::array<Pose, kLanes>& truth) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const Pose& pose = truth[static_cast<std::size_t>(lane)];
    for (Index i = 0; i < 2; ++i) error_[at(i)][lane] = x_[at(i)][lane] - pose[i];
    error_[2][lane] = wrap_angle(x_[2][lane] - pose[2]);
  }
  for (Index l = 0; l < world_.states(); ++l) {
    for (Index c = 0; c < 2; ++c) {
      const double place = world_.landmarks[at(l)][c];
      const Lanes& x = x_[at(3 + 2 * l + c)];
      Lanes& error = error_[at(3 + 2 * l + c)];
      for (int lane = 0; lane < kLanes; ++lane) error[lane] = x[lane] - place;
      for (int lane = 0; known_[at(l)] != kAllLanes && lane < kLanes; ++lane) {
        if (!has(known_[at(l)], lane)) error[lane] = 0.0;
      }
    }
  }
}

/// `error_` being that of the state now.
void PlanarLanes::follow_nees(const std::array<Pose, kLanes>& truth, bool logarithms) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const Pose& pose = truth[static_cast<std::size_t>(lane)];
    for (Index i = 0; i < 3; ++i) prior_[at(i)][lane] = predicted_[at(i)][lane] - pose[i];
    prior_[2][lane] = wrap_angle(prior_[2][lane]);
  }
  nees_along_run_.correct(kernel_data(), prior_, logarithms);
  for (const auto& [lane, state, J_r, noise] : initialised_) {
    nees_along_run_.append(lane, state, J_r, noise, error_, known_);
  }
  nees_along_run_.judge(kernel_data(), error_);
}

/// Of the states whose variance is not zero.
void PlanarLanes::factor_covariance(bool normalise) {
  for (Index i = 0; i < padded_; ++i) {
    const Lanes& variance = covariance_at(i, i);
    for (int lane = 0; lane < kLanes; ++lane) {
      const bool counts = variance[lane] != 0.0;
      diagonal_[at(i)][lane] = counts ? variance[lane] : 1.0;
      whitened_error_[at(i)][lane] = counts ? error_[at(i)][lane] : 0.0;
    }
  }
  const PlanarLanesNees nees{.padded = padded_,
                             .P = data(P_),
                             .diagonal = data(diagonal_),
                             .error = data(whitened_error_),
                             .below = normalise ? kMostBelow : 1,
                             .L = data(L_),
                             .nees = nees_.of,
                             .vehicle_nees = vehicle_nees_.of,
                             .check = check_.of,
                             .map_nees = map_nees_.of,
                             .doubt = doubt_.of};
  kernel_.nees(nees);
  if (normalise) kernel_.normalise(nees);
}

/// By the factor at hand.
void PlanarLanes::check_nees() {
  for (int lane = 0; lane < kLanes; ++lane) {
    if (!nees_along_run_.has_value(lane)) continue;
    const bool sound = check_[lane] == 0.0 && doubt_[lane] * NeesSolver::least_pivot(states_) < 1.0;
    if (!sound || !agree(nees_along_run_.nees(lane), nees_[lane], states_)) nees_along_run_.distrust(lane);
  }
}

void PlanarLanes::judge(const std::array<Pose, kLanes>& truth, bool normalise, Factor factor) {
  compute_errors(truth);
  follow_nees(truth, normalise);
  checked_ = factor == Factor::check;
  if (checked_ || !nees_along_run_.all_have_values(static_cast<LaneSet>(~lost_)))
    factor_covariance(normalise);
  if (checked_) check_nees();
  if (normalise) {
    kernel_.share_noise(kernel_data());
    kernel_.landmark_nees(kernel_data(), data(error_), data(landmark_nees_));
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    PlanarStep& s = steps_[static_cast<std::size_t>(lane)];
    // An update that failed says nothing of how large the error is.
    const double largest = nees_along_run_.largest_error(lane);
    const bool diverged = std::isnan(largest) || (s.update.ok && !(largest < kDivergedError_m));
    const bool followed = nees_along_run_.has_value(lane);
    const bool indefinite = !s.update.ok || !(followed || check_[lane] == 0.0);
    s.outcome = diverged ? Outcome::diverged : indefinite ? Outcome::not_positive_definite : Outcome::ok;
    if (s.outcome != Outcome::ok) {
      lost_ = with(lost_, lane);
      continue;
    }
    s.nees = followed ? nees_along_run_.nees(lane) : nees_[lane];
    s.nees_dof = nees_along_run_.dof(lane);
    s.vehicle_nees = followed ? nees_along_run_.vehicle_nees(lane) : vehicle_nees_[lane];
    s.traces.all = nees_along_run_.trace(lane);
    s.traces.position = covariance_at(0, 0)[lane] + covariance_at(1, 1)[lane];
    s.traces.heading = covariance_at(2, 2)[lane];
    s.traces.landmarks = s.traces.all - s.traces.position - s.traces.heading;
    s.position_error_squared = error_[0][lane] * error_[0][lane] + error_[1][lane] * error_[1][lane];
    s.heading_error_squared = error_[2][lane] * error_[2][lane];
    s.map_error_squared = nees_along_run_.map_error(lane);
    s.landmarks = count_[static_cast<std::size_t>(lane)];
  }
}

bool PlanarLanes::normalised(int lane, NormalisedStep& told) const {
  const PlanarStep& s = step(lane);
  const Index n = 3 + 2 * s.landmarks;
  const bool followed = nees_along_run_.has_value(lane);
  const bool full_rank = s.nees_dof == n && (followed || doubt_[lane] * NeesSolver::least_pivot(n) < 1.0);
  const bool update = s.update.dof == 0 || doubt_of_S_[lane] * NeesSolver::least_pivot(s.update.dof) < 1.0;
  if (!full_rank || !update || !std::isfinite(s.nees) || !std::isfinite(s.update.nis)) return false;
  told.states.resize(at(n));
  told.estimate.resize(n);
  told.error.resize(n);
  told.variance.resize(n);
  for (Index place = 0, i = 0; place < states_; ++place) {
    if (place > 2 && !has(known_[at((place - 3) / 2)], lane)) continue;
    told.states[at(i)] = place;
    told.estimate[i] = x_[at(place)][lane];
    told.error[i] = error_[at(place)][lane];
    told.variance[i] = covariance_at(place, place)[lane];
    ++i;
  }
  if (checked_ && n <= kLargestTold) {
    told.P.resize(n, n);
    for (Index j = 0; j < n; ++j) {
      for (Index i = j; i < n; ++i)
        told.P(i, j) = covariance_at(told.states[at(i)], told.states[at(j)])[lane];
    }
  } else {
    told.P.resize(0, 0);
  }
  told.whole = {s.nees, n};
  const Index pivots = kLanes * (padded_ + kMostBelow + 1);
  told.log_determinant = followed ? nees_along_run_.log_determinant(lane)
                                  : -2.0 * log_of_product(&L_[0].of[lane], padded_, pivots);
  normalise_blocks(lane, told);
  take_moving(lane, told);
  told.innovations.resize(1);
  normalise_innovation(lane, told.innovations.front());
  return true;
}

/// The pose, its parts, the single landmarks, and the map.
void PlanarLanes::normalise_blocks(int lane, NormalisedStep& told) const {
  const PlanarStep& s = step(lane);
  const bool followed = nees_along_run_.has_value(lane);
  const auto whitened = [&](Index i) { return L_[at(padded_ + i * (padded_ + kMostBelow))][lane]; };
  const Eigen::Vector3d u = followed ? nees_along_run_.vehicle_whitened(lane)
                                     : Eigen::Vector3d(whitened(0), whitened(1), whitened(2));
  told.lead.error = told.error.head<3>();
  told.lead.P.resize(3, 3);
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) told.lead.P(i, j) = covariance_at(i, j)[lane];
  }
  told.position.error = told.error.head<2>();
  told.position.P = told.lead.P.topLeftCorner<2, 2>();
  told.blocks.clear();
  told.blocks.push_back({s.vehicle_nees, 3});
  told.blocks.push_back({u[0] * u[0] + u[1] * u[1], 2});
  const double heading = told.error[2] / std::sqrt(told.variance[2]);
  told.blocks.push_back({heading * heading, 1});
  for (Index l = 0; l < std::min(world_.states(), kSingleLandmarks); ++l) {
    const bool known = has(known_[at(l)], lane);
    told.blocks.push_back(known ? NormalisedSquare{landmark_nees_[at(l)][lane], 2} : NormalisedSquare{});
  }
  if (world_.states() == 0) return;
  const double map_nees = followed ? nees_along_run_.map_nees(lane) : map_nees_[lane];
  told.blocks.push_back(s.landmarks > 0 ? NormalisedSquare{map_nees, 2 * s.landmarks} : NormalisedSquare{});
}

/// The pose and one landmark; where all landmarks are anchors, the position.
void PlanarLanes::take_moving(int lane, NormalisedStep& told) const {
  const auto known = [&](Index l) { return has(known_[at(l)], lane); };
  const Index chosen = landmark_in_turn(told.step, std::min(world_.states(), kSingleLandmarks), known);
  MovingPart& moving = told.moving;
  moving.places.clear();
  if (world_.states() == 0) moving = {told.position, {0, 1}};
  if (chosen < 0) return;
  Index i = 3;
  for (Index l = 0; l < chosen; ++l) i += known(l) ? 2 : 0;
  const std::array<Index, 5> places = {0, 1, 2, i, i + 1};  // not on the heap, as Eigen copies it
  moving.places.assign(places.begin(), places.end());
  moving.error = told.error(places);
  const std::array<Index, 5> states = {0, 1, 2, 3 + 2 * chosen, 4 + 2 * chosen};
  moving.P.resize(5, 5);
  for (Index a = 0; a < 5; ++a) {
    for (Index b = 0; b < 5; ++b) moving.P(a, b) = covariance_at(states[at(a)], states[at(b)])[lane];
  }
}

void PlanarLanes::normalise_innovation(int lane, NormalisedInnovation& told) const {
  const UpdateResult& update = step(lane).update;
  told.dof = update.dof > 0 ? update.dof : -1;
  if (update.dof == 0) return;
  told.value = update.nis;
  told.nu.resize(update.dof);
  told.whitened.resize(update.dof);
  told.variance.resize(update.dof);
  told.covariance.resize(update.dof / 2);
  Index i = 0;
  for (Index b = 0; b < measured_; ++b) {
    if (!has(used_[at(b)], lane)) continue;
    for (Index c = 2 * b; c < 2 * b + 2; ++c, ++i) {
      told.nu[i] = nu_[at(c)][lane];
      told.whitened[i] = update_at(2 * measured_ + padded_, c)[lane];
      told.variance[i] = innovation_covariance_[at(3 * b + c % 2)][lane];
    }
    told.covariance[i / 2 - 1] = innovation_covariance_[at(3 * b + 2)][lane];
  }
  // Where a lane saw nothing, S and R are one.
  const double m = static_cast<double>(update.dof);
  told.noise_share = (share_[lane] - (static_cast<double>(2 * measured_) - m)) / m;
}

// ------------------------------------------------------------------------------------- one lane, to look at

std::vector<int> PlanarLanes::landmarks(int lane) const {
  std::vector<int> numbers;
  for (Index l = 0; l < world_.states(); ++l) {
    if (has(known_[at(l)], lane)) numbers.push_back(static_cast<int>(l));
  }
  return numbers;
}

/// Places of the known states.
std::vector<Index> PlanarLanes::states_of(int lane) const {
  std::vector<Index> places = {0, 1, 2};
  for (const int l : landmarks(lane)) {
    places.push_back(3 + 2 * l);
    places.push_back(4 + 2 * l);
  }
  return places;
}

/// Columns of the last update that were this lane's.
std::vector<Index> PlanarLanes::columns_of(int lane) const {
  std::vector<Index> columns;
  for (Index b = 0; b < measured_; ++b) {
    if (!has(used_[at(b)], lane)) continue;
    columns.push_back(2 * b);
    columns.push_back(2 * b + 1);
  }
  return columns;
}

Vector PlanarLanes::state(int lane) const {
  const std::vector<Index> places = states_of(lane);
  Vector x(std::ssize(places));
  for (Index i = 0; i < x.size(); ++i) x[i] = x_[at(places[at(i)])][lane];
  return x;
}

Matrix PlanarLanes::covariance(int lane) const {
  const std::vector<Index> places = states_of(lane);
  Matrix P(std::ssize(places), std::ssize(places));
  for (Index i = 0; i < P.rows(); ++i) {
    for (Index j = 0; j < P.cols(); ++j) P(i, j) = covariance_at(places[at(i)], places[at(j)])[lane];
  }
  return P;
}

Vector PlanarLanes::innovation(int lane) const {
  const std::vector<Index> columns = columns_of(lane);
  Vector nu(std::ssize(columns));
  for (Index i = 0; i < nu.size(); ++i) nu[i] = nu_[at(columns[at(i)])][lane];
  return nu;
}

/// L of the last update.
Matrix PlanarLanes::update_root(int lane) const {
  const std::vector<Index> columns = columns_of(lane);
  Matrix L = Matrix::Zero(std::ssize(columns), std::ssize(columns));
  for (Index i = 0; i < L.rows(); ++i) {
    for (Index j = 0; j < i; ++j) L(i, j) = update_at(columns[at(i)], columns[at(j)])[lane];
    L(i, i) = 1.0 / update_at(columns[at(i)], columns[at(i)])[lane];
  }
  return L;
}

Matrix PlanarLanes::innovation_covariance(int lane) const {
  const Matrix L = update_root(lane);
  return L * L.transpose();
}

Matrix PlanarLanes::gain(int lane) const {
  const std::vector<Index> columns = columns_of(lane), places = states_of(lane);
  Matrix W(std::ssize(places), std::ssize(columns));
  for (Index i = 0; i < W.rows(); ++i) {
    for (Index j = 0; j < W.cols(); ++j) {
      W(i, j) = update_at(2 * measured_ + places[at(i)], columns[at(j)])[lane];
    }
  }
  return update_root(lane).transpose().triangularView<Eigen::Upper>().solve(W.transpose()).transpose();
}

}  // namespace credence::internal
