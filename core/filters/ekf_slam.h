#pragma once

#include <span>
#include <stdexcept>
#include <vector>

#include "core/filters/landmark_table.h"
#include "core/filters/sequential_update.h"
#include "core/inflation/inflation_along_run.h"
#include "core/inflation/inflation_rule.h"
#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/matrix_buffer.h"
#include "core/linear_algebra/mirror.h"
#include "core/models/slam_model.h"
#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence {

/// A measurement of one landmark, its identity known.
template <class Model>
struct Observation {
  int landmark = 0;  ///< the world's number of the landmark, >= 0
  Eigen::Matrix<double, Model::kMeasurement, 1> z;
};

/// What an update did.
struct UpdateResult {
  bool ok = true;            ///< false: S was not positive definite and nothing was changed
  double nis = 0.0;          ///< νᵀ S⁻¹ ν of the batch, 0 if nothing known was seen
  Index dof = 0;             ///< dimension of ν: known landmarks and anchors seen × kMeasurement
  Index initialised = 0;     ///< landmarks seen for the first time
  double trace_prior = 0.0;  ///< tr P after inflation, before the update
  bool converged = true;     ///< the exact minimal trace was reached to its tolerance
};

/// EKF-SLAM by eqs (3)-(10) of [Vidal-Calleja 2004]: dense covariance, Joseph form, known association.
///
/// x = [pose; landmarks in the order of first sight]. A step is predict(u) then update(z); covariance
/// inflation, if any, comes between the two, or within the update if the rule is sequential. A predict costs
/// O(n), an update with m measurements O(n² m).
template <class Model>
class EkfSlam {
 public:
  static constexpr int kPose = Model::kPose, kControl = Model::kControl;
  static constexpr int kLandmark = Model::kLandmark, kMeasurement = Model::kMeasurement;
  using PoseVector = Eigen::Matrix<double, kPose, 1>;
  using PoseMatrix = Eigen::Matrix<double, kPose, kPose>;
  using ControlVector = Eigen::Matrix<double, kControl, 1>;
  using ControlMatrix = Eigen::Matrix<double, kControl, kControl>;
  using LandmarkVector = Eigen::Matrix<double, kLandmark, 1>;
  using MeasurementVector = Eigen::Matrix<double, kMeasurement, 1>;
  using MeasurementMatrix = Eigen::Matrix<double, kMeasurement, kMeasurement>;

  /// `Q` is the covariance of the noise on the control, `R` that of one measurement; both symmetric psd.
  EkfSlam(Model model, const ControlMatrix& Q, const MeasurementMatrix& R, InflationRule rule = {},
          std::span<const Anchor<Model>> anchors = {})
      : model_(std::move(model)), Q_(Q), R_(R), rule_(std::move(rule)), table_(anchors) {
    reset(PoseVector::Zero(), PoseMatrix::Zero());
  }

  /// Starts with a pose of covariance P and an empty map.
  void reset(const PoseVector& pose, const PoseMatrix& P);

  /// Starts with a pose and the landmarks `ids` in the state already: x is n, P n×n.
  ///
  /// Throws std::invalid_argument for sizes that do not match.
  void reset(VectorRef x, MatrixRef P, std::span<const int> ids);

  /// Time update: x_r ← f(x_r, u), P_rr ← F P_rr Fᵀ + G Q Gᵀ, P_rf ← F P_rf.
  void predict(const ControlVector& u);

  /// Inflation, measurement update with all known landmarks and anchors in one batch, and initialisation of
  /// the landmarks seen for the first time. A landmark must not appear twice in one batch.
  UpdateResult update(std::span<const Observation<Model>> observations) {
    UpdateResult result;
    result.converged = inflate_prior(P_, inflation_).converged;
    result.trace_prior = P_.trace();
    linearise(observations);
    result.dof = kMeasurement * static_cast<Index>(rows_.size());
    if (result.dof > 0 && !correct(result)) {
      result.ok = false;
      return result;
    }
    result.initialised = initialise(observations);
    if (result.initialised > 0 && rule_.is_sequential()) {
      // The correlations of one new landmark are a star, for which the pairwise sum is the least trace.
      inflate(P_, layout(), rule_.inflation, InflationSolution::pairwise);
    }
    return result;
  }

  const Vector& state() const { return x_; }
  const Matrix& covariance() const { return P_; }
  /// P with the inflation that the next update will begin with, n×n.
  Matrix inflated_prior() const {
    Matrix P = P_;
    InflationAlongRun copy = inflation_;
    inflate_prior(P, copy);
    return P;
  }
  std::span<const int> landmarks() const {
    return table_.ids();
  }  ///< their numbers, in the order of the state
  PoseVector pose() const { return x_.template head<kPose>(); }
  BlockLayout layout() const {
    return {.vehicle = kPose, .landmark = kLandmark, .landmarks = std::ssize(table_.ids())};
  }
  Model& model() { return model_; }
  VectorRef innovation() const { return nu_.vector(); }            ///< ν of the last update
  MatrixRef innovation_covariance() const { return S_.matrix(); }  ///< its S
  MatrixRef gain() const { return K_.matrix(); }                   ///< its K, n×dim ν

  /// Where landmark `id` starts in the state, −1 if it is not there.
  Index offset_of(int id) const { return table_.offset_of(id); }

 private:
  struct Row {  ///< Jacobian of one measurement: the vehicle's columns and those of its landmark
    Index offset = -1;
    Eigen::Matrix<double, kMeasurement, kPose> H_r;
    Eigen::Matrix<double, kMeasurement, kLandmark> H_l;
  };

  /// The landmarks of the state are `ids`.
  void know(std::span<const int> ids) {
    table_.reset(ids);
    inflation_.reset();
  }

  /// All that is added before an update; within it a sequential rule adds the rest.
  InflationStep inflate_prior(Matrix& P, InflationAlongRun& along) const {
    if (rule_.constant.size() == P.size() && P.size() > 0) P += rule_.constant;
    return along.apply(P, layout(), rule_);
  }

  /// Innovations and Jacobians of what is known, at the current estimate.
  void linearise(std::span<const Observation<Model>> observations);

  /// out = A Hᵀ for a symmetric or general n×n A.
  void times_observation_transposed(const Matrix& A, MatrixBuffer& out) const {
    auto AHt = out.resize(A.rows(), kMeasurement * static_cast<Index>(rows_.size()));
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      auto columns = AHt.template middleCols<kMeasurement>(kMeasurement * static_cast<Index>(i));
      columns.noalias() = A.template leftCols<kPose>() * rows_[i].H_r.transpose();
      if (rows_[i].offset < 0) continue;
      columns.noalias() += A.template middleCols<kLandmark>(rows_[i].offset) * rows_[i].H_l.transpose();
    }
  }

  void compute_innovation_covariance() {
    times_observation_transposed(P_, PHt_);
    const auto PHt = PHt_.matrix();
    auto S = S_.resize(PHt.cols(), PHt.cols());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      auto block = S.template middleRows<kMeasurement>(kMeasurement * static_cast<Index>(i));
      block.noalias() = rows_[i].H_r * PHt.template topRows<kPose>();
      if (rows_[i].offset >= 0) {
        block.noalias() += rows_[i].H_l * PHt.template middleRows<kLandmark>(rows_[i].offset);
      }
      block.template middleCols<kMeasurement>(kMeasurement * static_cast<Index>(i)) += R_;
    }
    symmetrise(S);
  }

  bool correct(UpdateResult& result);

  /// P ← (I − K H) P (I − K H)ᵀ + K R Kᵀ, as A = P − K H P and P ← A − (A Hᵀ − K R) Kᵀ.
  void joseph_correct(const Eigen::LLT<Eigen::Ref<Matrix>>& llt, Eigen::Map<Matrix>& K) {
    const auto PHt = PHt_.matrix();
    auto K_t = K_t_.resize(PHt.cols(), PHt.rows());
    K_t = PHt.transpose();
    llt.solveInPlace(K_t);
    K = K_t.transpose();
    P_.noalias() -= K * PHt.transpose();
    times_observation_transposed(P_, AHt_);
    auto AHt = AHt_.matrix();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Index c = kMeasurement * static_cast<Index>(i);
      AHt.template middleCols<kMeasurement>(c).noalias() -= K.template middleCols<kMeasurement>(c) * R_;
    }
    P_.noalias() -= AHt * K.transpose();
    symmetrise(P_);
  }

  bool sequential_correct(Eigen::Map<Matrix>& K) {
    const Index m = K.cols();
    auto H = H_.resize(m, x_.size());
    H.setZero();
    auto r = r_.resize(m);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Index c = kMeasurement * static_cast<Index>(i);
      H.template block<kMeasurement, kPose>(c, 0) = rows_[i].H_r;
      if (rows_[i].offset >= 0) H.template block<kMeasurement, kLandmark>(c, rows_[i].offset) = rows_[i].H_l;
      r.template block<kMeasurement, 1>(c, 0) = R_.diagonal();
    }
    return sequential_update(P_, layout(), H, r.col(0), K, sequential_, *rule_.map_bound());
  }

  /// New landmarks with their full cross-covariances: P_lx = J_r P_rx, P_ll = J_r P_rr J_rᵀ + J_z R J_zᵀ.
  Index initialise(std::span<const Observation<Model>> observations);

  Model model_;
  ControlMatrix Q_;
  MeasurementMatrix R_;
  InflationRule rule_;
  LandmarkTable<Model> table_;
  Vector x_;
  Matrix P_;
  InflationAlongRun inflation_;

  // Of the last update; kept to be read and so that a step allocates nothing.
  std::vector<Row> rows_;
  MatrixBuffer nu_, S_, K_;
  MatrixBuffer whitened_, S_root_, K_t_, PHt_, AHt_, H_, r_;
  SequentialWorkspace sequential_;
};

// Not in the class: what is defined there is inline, and compiled again wherever it is called.
template <class Model>
void EkfSlam<Model>::reset(const PoseVector& pose, const PoseMatrix& P) {
  know({});
  x_.resize(kPose);
  x_.template head<kPose>() = pose;
  P_.resize(kPose, kPose);
  P_.template topLeftCorner<kPose, kPose>() = P;
}

template <class Model>
void EkfSlam<Model>::reset(VectorRef x, MatrixRef P, std::span<const int> ids) {
  const Index n = kPose + kLandmark * static_cast<Index>(ids.size());
  if (x.size() != n || P.rows() != n || P.cols() != n) {
    throw std::invalid_argument("EkfSlam::reset: x and P must have the size of the pose and the landmarks");
  }
  know(ids);
  x_ = x;
  P_ = P;
}

template <class Model>
void EkfSlam<Model>::predict(const ControlVector& u) {
  const auto motion = model_.move(x_.template head<kPose>(), u);
  x_.template head<kPose>() = motion.pose;
  const PoseMatrix P_rr = P_.template topLeftCorner<kPose, kPose>();
  const PoseMatrix predicted = motion.F * P_rr * motion.F.transpose() + motion.G * Q_ * motion.G.transpose();
  P_.template topLeftCorner<kPose, kPose>() = 0.5 * (predicted + predicted.transpose());
  for (Index j = kPose; j < P_.cols(); ++j) {
    const PoseVector column = motion.F * P_.col(j).template head<kPose>();
    P_.col(j).template head<kPose>() = column;
    P_.row(j).template head<kPose>() = column.transpose();
  }
}

template <class Model>
void EkfSlam<Model>::linearise(std::span<const Observation<Model>> observations) {
  rows_.clear();
  auto nu = nu_.resize(kMeasurement * static_cast<Index>(observations.size()));
  const PoseVector x_r = pose();
  for (const Observation<Model>& o : observations) {
    const LandmarkVector* anchor = table_.anchor(o.landmark);
    const Index offset = anchor ? -1 : table_.offset_of(o.landmark);
    if (!anchor && offset < 0) continue;
    const LandmarkVector l = anchor ? *anchor : LandmarkVector(x_.template segment<kLandmark>(offset));
    const auto predicted = model_.predict(x_r, l);
    nu.template block<kMeasurement, 1>(kMeasurement * static_cast<Index>(rows_.size()), 0) =
        model_.innovation(o.z, predicted.z);
    rows_.push_back({offset, predicted.H_r, predicted.H_l});
  }
  nu_.resize(kMeasurement * static_cast<Index>(rows_.size()));  // leaves the first of them as they are
}

template <class Model>
bool EkfSlam<Model>::correct(UpdateResult& result) {
  compute_innovation_covariance();
  const auto nu = nu_.vector();
  auto S_root = S_root_.resize(nu.size(), nu.size());
  S_root = S_.matrix();
  const Eigen::LLT<Eigen::Ref<Matrix>> llt(S_root);
  if (llt.info() != Eigen::Success || !S_.matrix().allFinite()) return false;
  whitened_.resize(nu.size());
  auto whitened = whitened_.vector();
  whitened = nu;
  llt.matrixL().solveInPlace(whitened);
  result.nis = whitened.squaredNorm();
  auto K = K_.resize(x_.size(), nu.size());
  if (rule_.is_sequential()) {
    if (!sequential_correct(K)) return false;
  } else {
    joseph_correct(llt, K);
  }
  x_.noalias() += K * nu;
  PoseVector x_r = pose();
  model_.wrap_pose(x_r);
  x_.template head<kPose>() = x_r;
  return true;
}

template <class Model>
Index EkfSlam<Model>::initialise(std::span<const Observation<Model>> observations) {
  Index count = 0;
  for (const Observation<Model>& o : observations) {
    if (table_.is_known(o.landmark)) continue;
    const auto placed = model_.place(pose(), o.z);
    const Index n = x_.size();
    table_.append(o.landmark);
    x_.conservativeResize(n + kLandmark);
    x_.template tail<kLandmark>() = placed.position;
    P_.conservativeResize(n + kLandmark, n + kLandmark);
    P_.bottomLeftCorner(kLandmark, n) = placed.J_r * P_.topLeftCorner(kPose, n);
    P_.topRightCorner(n, kLandmark) = P_.bottomLeftCorner(kLandmark, n).transpose();
    const Eigen::Matrix<double, kLandmark, kLandmark> own =
        placed.J_r * P_.template topLeftCorner<kPose, kPose>() * placed.J_r.transpose() +
        placed.J_z * R_ * placed.J_z.transpose();
    P_.template bottomRightCorner<kLandmark, kLandmark>() = 0.5 * (own + own.transpose());
    ++count;
  }
  return count;
}

extern template class EkfSlam<PlanarModel>;
extern template class EkfSlam<MonobotModel>;

}  // namespace credence
