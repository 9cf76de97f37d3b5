#pragma once

#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/filters/ekf_slam.h"
#include "core/filters/joseph_update.h"
#include "core/filters/landmark_table.h"
#include "core/filters/panel_covariance.h"
#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/matrix_buffer.h"

namespace credence {

/// How FastEkfSlam works; no choice changes a bit of its results.
struct FastEkfSlamOptions {
  /// Updates after which P_ff is brought up to date in memory; 1: after each. Of 4, 8, 12 and 16, measured
  /// with one landmark seen at a time, 4 was fastest at 100 landmarks, 8 at 500 and 16 at 1000; 12 was at no
  /// size more than 12 % slower than the fastest.
  int flush_steps = 12;
  InstructionSet instruction_set = best_instruction_set();
};

/// EKF-SLAM by the paper's eqs (3)-(10) for large maps, with the results of EkfSlam without inflation to
/// rounding: a prediction costs O(1), an update with m measurements n² m multiply-adds in one pass over one
/// triangle of P, or one pass for several updates (core/filters/panel_covariance.h).
///
/// The update is P ← P − W Wᵀ with W = P Hᵀ L⁻ᵀ and S = L Lᵀ, symmetric by construction. Its rounding is that
/// of the prior, and relative to the posterior in the measured directions that times tr(R⁻¹ S). An update
/// with tr(R⁻¹ S) > 1e8 (a prior that vague, or a singular R), or that would leave a variance negative, is
/// done in Joseph's form instead, in O(n² m) with allocation, and counted. There is no covariance inflation:
/// it needs all of P at each step.
template <class Model>
class FastEkfSlam {
 public:
  static constexpr int kPose = Model::kPose, kControl = Model::kControl;
  static constexpr int kLandmark = Model::kLandmark, kMeasurement = Model::kMeasurement;
  using PoseVector = Eigen::Matrix<double, kPose, 1>;
  using PoseMatrix = Eigen::Matrix<double, kPose, kPose>;
  using ControlVector = Eigen::Matrix<double, kControl, 1>;
  using ControlMatrix = Eigen::Matrix<double, kControl, kControl>;
  using LandmarkVector = Eigen::Matrix<double, kLandmark, 1>;
  using MeasurementMatrix = Eigen::Matrix<double, kMeasurement, kMeasurement>;

  static constexpr double kMostCancellation = 1e8;  ///< of tr(R⁻¹ S), for P − W Wᵀ

  /// `Q` is the covariance of the noise on the control, `R` that of one measurement; both symmetric psd.
  /// Throws std::invalid_argument for flush_steps < 1, an instruction set that is not there, or an anchor
  /// with a negative number.
  FastEkfSlam(Model model, const ControlMatrix& Q, const MeasurementMatrix& R,
              FastEkfSlamOptions options = {}, std::span<const Anchor<Model>> anchors = {})
      : model_(std::move(model)),
        Q_(Q),
        R_(R),
        R_llt_(R),
        table_(anchors),
        P_(kPose, kLandmark, options.flush_steps, options.instruction_set) {
    reset(PoseVector::Zero(), PoseMatrix::Zero());
  }

  /// Starts with a pose of covariance P and an empty map.
  void reset(const PoseVector& pose, const PoseMatrix& P) { reset(pose, P, {}); }

  /// Starts with a pose and the landmarks `ids` in the state already: x is n, P n×n, its lower triangle read.
  ///
  /// Throws std::invalid_argument for sizes that do not match.
  void reset(VectorRef x, MatrixRef P, std::span<const int> ids);

  /// Time update: x_r ← f(x_r, u), P_rr ← F P_rr Fᵀ + G Q Gᵀ, P_rf ← F P_rf.
  void predict(const ControlVector& u);

  /// Measurement update with all known landmarks and anchors in one batch, and initialisation of the
  /// landmarks seen for the first time. A landmark must not appear twice in one batch. Allocates nothing once
  /// the map is known and as many measurements have come together as ever will.
  UpdateResult update(std::span<const Observation<Model>> observations) {
    UpdateResult result;
    result.trace_prior = P_.trace();
    linearise(observations);
    result.dof = std::ssize(nu_);
    corrected_ = result.dof > 0 && correct(result);
    if (result.dof > 0 && !corrected_) {
      result.ok = false;
      return result;
    }
    result.initialised = initialise(observations);
    return result;
  }

  const Vector& state() const { return x_; }
  Matrix covariance() const { return P_.dense(); }  ///< O(n²) and allocates
  /// Any block of P at any time, also between flushes; allocates. Throws std::invalid_argument beyond P.
  Matrix covariance_block(Index row, Index column, Index rows, Index columns) const {
    return P_.block(row, column, rows, columns);
  }
  double covariance_trace() const { return P_.trace(); }           ///< O(n)
  std::span<const int> landmarks() const { return table_.ids(); }  ///< numbers, in the order of the state
  PoseVector pose() const { return x_.template head<kPose>(); }
  BlockLayout layout() const {
    return {.vehicle = kPose, .landmark = kLandmark, .landmarks = std::ssize(table_.ids())};
  }
  Model& model() { return model_; }
  /// ν of the last update.
  VectorRef innovation() const { return Eigen::Map<const Vector>(nu_.data(), std::ssize(nu_)); }
  MatrixRef innovation_covariance() const { return S_.matrix(); }  ///< its S
  /// Its K, n×dim ν with the n before initialisation, or n×0 if it corrected nothing; O(n dim² ν), allocates.
  Matrix gain() const { return corrected_ ? solve_gain() : Matrix(x_.size(), 0); }
  Index joseph_updates() const { return joseph_updates_; }  ///< since the reset

  /// Where landmark `id` starts in the state, −1 if it is not there.
  Index offset_of(int id) const { return table_.offset_of(id); }

 private:
  /// Innovations and Jacobians of what is known, at the current estimate.
  void linearise(std::span<const Observation<Model>> observations);

  /// True if P − W Wᵀ would lose too much to rounding: the criterion of the class.
  bool cancels() const {
    if (R_llt_.info() != Eigen::Success) return true;
    double sum = 0.0;
    for (Index i = 0; i < std::ssize(nu_); i += kMeasurement) {
      const MeasurementMatrix S = S_.matrix().template block<kMeasurement, kMeasurement>(i, i);
      sum += R_llt_.solve(S).trace();
    }
    return !(sum <= kMostCancellation);
  }

  /// S and its Cholesky factor; false if S is not positive definite.
  bool factorise() {
    const Index dof = std::ssize(nu_);
    auto S = S_.resize(dof, dof);
    P_.project(batch_, S);
    for (Index i = 0; i < dof; i += kMeasurement) S.template block<kMeasurement, kMeasurement>(i, i) += R_;
    auto root = S_root_.resize(dof, dof);
    root = S;
    const Eigen::LLT<Eigen::Ref<Matrix>> in_place(root);
    return in_place.info() == Eigen::Success && S.allFinite();
  }

  bool correct(UpdateResult& result);

  bool correct_by_joseph() {
    Matrix P = P_.dense();
    joseph_update(P, batch_, solve_gain(), R_);
    if (!P.allFinite() || !(P.diagonal().minCoeff() >= 0.0)) return false;
    P_.replace(P);
    ++joseph_updates_;
    return true;
  }

  /// K = W L⁻¹.
  Matrix solve_gain() const {
    Matrix K = P_.whitened_columns();
    S_root_.matrix().template triangularView<Eigen::Lower>().template solveInPlace<Eigen::OnTheRight>(K);
    return K;
  }

  /// New landmarks with their full cross-covariances: P_lx = J_r P_rx, P_ll = J_r P_rr J_rᵀ + J_z R J_zᵀ.
  Index initialise(std::span<const Observation<Model>> observations);

  Model model_;
  ControlMatrix Q_;
  MeasurementMatrix R_;
  Eigen::LLT<MeasurementMatrix> R_llt_;
  LandmarkTable<Model> table_;
  Vector x_;
  PanelCovariance P_;
  Index joseph_updates_ = 0;

  // Of the last update; kept to be read and so that a step allocates nothing.
  ObservationBatch batch_;
  std::vector<double> nu_;
  MatrixBuffer S_, S_root_, whitened_;
  bool corrected_ = false;
};

// Not in the class: what is defined there is inline, and compiled again wherever it is called.
template <class Model>
void FastEkfSlam<Model>::reset(VectorRef x, MatrixRef P, std::span<const int> ids) {
  const Index n = kPose + kLandmark * static_cast<Index>(ids.size());
  if (x.size() != n || P.rows() != n || P.cols() != n) {
    throw std::invalid_argument(
        "FastEkfSlam::reset: x and P must have the size of the pose and the landmarks");
  }
  table_.reset(ids);
  x_ = x;
  P_.reset(P);
  nu_.clear();
  S_.resize(0, 0);
  corrected_ = false;
  joseph_updates_ = 0;
}

template <class Model>
void FastEkfSlam<Model>::predict(const ControlVector& u) {
  const auto motion = model_.move(x_.template head<kPose>(), u);
  x_.template head<kPose>() = motion.pose;
  const PoseMatrix noise = motion.G * Q_ * motion.G.transpose();
  P_.predict(motion.F, noise);
}

template <class Model>
void FastEkfSlam<Model>::linearise(std::span<const Observation<Model>> observations) {
  batch_.clear(kPose, kLandmark, kMeasurement);
  nu_.clear();
  const PoseVector x_r = pose();
  for (const Observation<Model>& o : observations) {
    const LandmarkVector* anchor = table_.anchor(o.landmark);
    const Index column = anchor ? -1 : table_.column_of(o.landmark);
    if (!anchor && column < 0) continue;
    const LandmarkVector l = anchor ? *anchor : x_.template segment<kLandmark>(kPose + column);
    const auto predicted = model_.predict(x_r, l);
    const Eigen::Matrix<double, kMeasurement, 1> nu = model_.innovation(o.z, predicted.z);
    nu_.insert(nu_.end(), nu.data(), nu.data() + kMeasurement);
    batch_.add(column, predicted.H_r, predicted.H_l);
  }
}

template <class Model>
bool FastEkfSlam<Model>::correct(UpdateResult& result) {
  if (!factorise()) return false;
  const auto L = std::as_const(S_root_).matrix();
  auto whitened = whitened_.resize(L.rows()).col(0);
  whitened = innovation();
  L.template triangularView<Eigen::Lower>().solveInPlace(whitened);
  const bool positive = P_.whiten(L, whitened);
  if (positive && !cancels()) {
    P_.commit();
  } else if (!correct_by_joseph()) {
    return false;
  }
  result.nis = whitened.squaredNorm();
  P_.add_state_change(x_);
  PoseVector x_r = pose();
  model_.wrap_pose(x_r);
  x_.template head<kPose>() = x_r;
  return true;
}

template <class Model>
Index FastEkfSlam<Model>::initialise(std::span<const Observation<Model>> observations) {
  Index count = 0;
  for (const Observation<Model>& o : observations) {
    if (table_.is_known(o.landmark)) continue;
    const auto placed = model_.place(pose(), o.z);
    const PoseMatrix P_rr = P_.block(0, 0, kPose, kPose);
    const Eigen::Matrix<double, kLandmark, kLandmark> own =
        placed.J_r * P_rr * placed.J_r.transpose() + placed.J_z * R_ * placed.J_z.transpose();
    P_.append(placed.J_r, 0.5 * (own + own.transpose()));
    const Index n = x_.size();
    x_.conservativeResize(n + kLandmark);
    x_.template tail<kLandmark>() = placed.position;
    table_.append(o.landmark);
    ++count;
  }
  return count;
}

extern template class FastEkfSlam<PlanarModel>;
extern template class FastEkfSlam<MonobotModel>;

}  // namespace credence
