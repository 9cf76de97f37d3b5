#pragma once

#include <span>
#include <stdexcept>
#include <vector>

#include "core/filters/arrow_covariance.h"
#include "core/filters/block_map_state.h"
#include "core/filters/slam_phases.h"
#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/matrix_buffer.h"
#include "core/models/slam_model.h"

namespace credence {

/// EKF-SLAM whose map stays block diagonal, O(N) in time and memory (theory, sections 4 and 5, `sequential`).
///
/// The filter that EkfSlam is with inflation of the map and the solution `sequential`, with an arrow for a
/// covariance and never an n×n matrix: a predict costs O(1), an update with m landmarks O(m N), and so does
/// the initialisation of m. The pending changes of state() and covariance() are applied when they are read,
/// O(N); hence one filter belongs to one thread, even to read.
template <class Model>
class BlockMapEkfSlam : public internal::SlamPhases<Model> {
 public:
  using Phases = internal::SlamPhases<Model>;
  using Phases::kPose, Phases::kLandmark, Phases::kMeasurement;
  using typename Phases::ControlMatrix;
  using typename Phases::ControlVector;
  using typename Phases::LandmarkVector;
  using typename Phases::MeasurementMatrix;
  using typename Phases::PoseMatrix;
  using typename Phases::PoseVector;

  /// `Q` is the covariance of the noise on the control, `R` that of one measurement; both symmetric, Q psd
  /// and R positive definite where it is not diagonal.
  BlockMapEkfSlam(Model model, const ControlMatrix& Q, const MeasurementMatrix& R,
                  internal::MapBound bound = internal::MapBound::least_trace,
                  std::span<const internal::Anchor<Model>> anchors = {})
      : Phases(std::move(model), Q, R, anchors), bound_(bound) {
    if (!R_.isDiagonal(0.0)) {
      const Eigen::LLT<MeasurementMatrix> llt(R_);
      if (llt.info() != Eigen::Success) {
        throw std::invalid_argument("BlockMapEkfSlam: R must be diagonal or positive definite");
      }
      root_ = llt.matrixL();
      whiten_ = true;
    }
    reset(PoseVector::Zero(), PoseMatrix::Zero());
  }

  /// Starts with a pose of covariance P and an empty map.
  void reset(const PoseVector& pose, const PoseMatrix& P);

  /// Starts with a pose and the landmarks `ids` in the state already. Throws std::invalid_argument for sizes
  /// that do not match, and for a landmark that is there twice.
  void reset(VectorRef x, internal::ArrowCovariance P, std::span<const int> ids);

  /// Time update: x_r ← f(x_r, u), P_rr ← F P_rr Fᵀ + G Q Gᵀ, P_rf ← F P_rf.
  void predict(const ControlVector& u);

  /// Measurement update with all known landmarks and anchors, linearised at the prior, with the inflation
  /// after each scalar, and initialisation of the landmarks seen for the first time. Throws as
  /// EkfSlam::update.
  UpdateResult update(std::span<const Observation<Model>> observations) {
    UpdateResult result;
    result.trace_prior = map_.trace();
    map_.flush_if_crowded();
    this->linearise(observations, pose(), [this](Index offset) { return position(offset); });
    measure();
    result.dof = kMeasurement * static_cast<Index>(rows_.size());
    if (result.dof > 0) {
      result.ok = judge(result) && map_.correct(scalars_, bound_, keep_gain_ ? &K_ : nullptr);
      if (!result.ok) return result;
      if (whiten_ && keep_gain_) unwhiten_gain();
      PoseVector x_r = map_.pose();
      this->model_.wrap_pose(x_r);
      map_.set_pose(x_r);
    }
    result.initialised = this->initialise(
        observations, pose(), pose_covariance(),
        [this](const auto& position, const auto& J_r, const auto& own) { map_.append(position, J_r, own); });
    return result;
  }

  const Vector& state() const {
    map_.flush();
    return map_.x();
  }
  const internal::ArrowCovariance& covariance() const {
    map_.flush();
    return map_.covariance();
  }
  PoseVector pose() const { return map_.pose(); }
  const PoseMatrix& pose_covariance() const { return map_.vehicle_covariance(); }
  /// Where the landmark at `offset` of the state is; O(1), unlike state().
  LandmarkVector position(Index offset) const { return map_.position((offset - kPose) / kLandmark); }
  /// Asks updates to write down K, which costs them O(N m²).
  void keep_gain(bool keep) { keep_gain_ = keep; }
  const Matrix& gain() const { return K_; }  ///< K of the last update, n×dim ν; empty if it is not kept

  /// Memory that grows with the map.
  std::size_t bytes() const { return map_.bytes() + table_.bytes(); }

 private:
  using Scalar = typename internal::BlockMapState<kPose, kLandmark>::Scalar;
  using Phases::table_, Phases::Q_, Phases::R_, Phases::motion_, Phases::rows_, Phases::nu_, Phases::S_;
  using typename Phases::MeasurementVector;
  using typename Phases::Row;

  struct Measured {       ///< what P has of one measurement
    Index measured = -1;  ///< its landmark among those measured, −1: an anchor
    Eigen::Matrix<double, kPose, kMeasurement> column;  ///< vehicle rows of P Hᵀ
  };

  /// The landmarks of the rows, and their scalars.
  void measure();
  void append_scalars(const Row& row, Index measured, MeasurementVector nu);

  /// S of the batch at the prior, and its NIS.
  bool judge(UpdateResult& result);

  void set_innovation_block(Eigen::Map<Matrix>& S, std::size_t i, std::size_t k) const {
    const Row &row = rows_[i], &other = rows_[k];
    const Index measured = measured_[i].measured;
    MeasurementMatrix block = row.H_r * measured_[k].column;
    if (measured >= 0) {
      const auto& landmark = map_.measured(measured);
      block += row.H_l * (landmark.cross.transpose() * other.H_r.transpose());
      if (measured_[k].measured == measured) block += row.H_l * landmark.block * other.H_l.transpose();
    }
    if (i == k) block = (0.5 * (block + block.transpose()) + R_).eval();
    const Index a = kMeasurement * static_cast<Index>(i), b = kMeasurement * static_cast<Index>(k);
    S.template block<kMeasurement, kMeasurement>(a, b) = block;
    S.template block<kMeasurement, kMeasurement>(b, a) = block.transpose();
  }

  /// K is of whitened innovations L⁻¹ν: from the right by L⁻¹.
  void unwhiten_gain();

  MeasurementMatrix root_ = MeasurementMatrix::Zero();  ///< R = root rootᵀ, if it is not diagonal
  bool whiten_ = false, keep_gain_ = false;
  internal::MapBound bound_;
  mutable internal::BlockMapState<kPose, kLandmark> map_;  ///< reading it applies what is pending

  // Of the last update; kept to be read and so that a step allocates nothing.
  std::vector<Measured> measured_;  // of the rows
  std::vector<Scalar> scalars_;
  internal::MatrixBuffer S_root_, whitened_;
  Matrix K_;
};

// Not in the class: what is defined there is inline, and compiled again wherever it is called.
template <class Model>
void BlockMapEkfSlam<Model>::reset(const PoseVector& pose, const PoseMatrix& P) {
  internal::ArrowCovariance arrow(kPose, kLandmark);
  arrow.set_vehicle(P);
  reset(pose, std::move(arrow), {});
}

template <class Model>
void BlockMapEkfSlam<Model>::reset(VectorRef x, internal::ArrowCovariance P, std::span<const int> ids) {
  const Index n = kPose + kLandmark * static_cast<Index>(ids.size());
  if (x.size() != n || P.state_dim() != n || P.layout().vehicle != kPose ||
      P.layout().landmark != kLandmark) {
    throw std::invalid_argument(
        "BlockMapEkfSlam::reset: x and P must have the size of the pose and the landmarks");
  }
  table_.reset(ids);
  map_.reset(x, std::move(P));
}

template <class Model>
void BlockMapEkfSlam<Model>::predict(const ControlVector& u) {
  const auto motion = this->model_.move(map_.pose(), u);
  map_.set_pose(motion.pose);
  motion_ = {motion.F, motion.G * Q_ * motion.G.transpose()};
  map_.predict(motion_.F, motion_.noise);
}

template <class Model>
void BlockMapEkfSlam<Model>::measure() {
  measured_.clear();
  scalars_.clear();
  for (const Row& row : rows_) {
    const Index measured = row.offset < 0 ? -1 : map_.measure((row.offset - kPose) / kLandmark);
    append_scalars(row, measured,
                   nu_.vector().template segment<kMeasurement>(kMeasurement * std::ssize(measured_)));
    measured_.push_back({.measured = measured});
  }
}

template <class Model>
void BlockMapEkfSlam<Model>::append_scalars(const Row& row, Index measured, MeasurementVector nu) {
  auto H_r = row.H_r;
  auto H_l = row.H_l;
  if (whiten_) {
    const auto L = root_.template triangularView<Eigen::Lower>();
    L.solveInPlace(H_r);
    L.solveInPlace(H_l);
    L.solveInPlace(nu);
  }
  for (Index i = 0; i < kMeasurement; ++i) {
    scalars_.push_back(
        {measured, H_r.row(i).transpose(), H_l.row(i).transpose(), nu[i], whiten_ ? 1.0 : R_(i, i)});
  }
}

template <class Model>
bool BlockMapEkfSlam<Model>::judge(UpdateResult& result) {
  const auto nu = nu_.vector();
  auto S = S_.resize(nu.size(), nu.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    auto& [measured, column] = measured_[i];
    column = map_.vehicle_covariance() * row.H_r.transpose();
    if (measured >= 0) column += map_.measured(measured).cross * row.H_l.transpose();
    for (std::size_t k = 0; k <= i; ++k) set_innovation_block(S, i, k);
  }
  auto root = S_root_.resize(nu.size(), nu.size());
  root = S;
  const Eigen::LLT<Eigen::Ref<Matrix>> llt(root);
  if (llt.info() != Eigen::Success || !S.allFinite()) return false;
  whitened_.resize(nu.size());
  auto whitened = whitened_.vector();
  whitened = nu;
  llt.matrixL().solveInPlace(whitened);
  result.nis = whitened.squaredNorm();
  return true;
}

template <class Model>
void BlockMapEkfSlam<Model>::unwhiten_gain() {
  for (Index c = 0; c < K_.cols(); c += kMeasurement) {
    auto columns = K_.template middleCols<kMeasurement>(c);
    root_.template triangularView<Eigen::Lower>().template solveInPlace<Eigen::OnTheRight>(columns);
  }
}

extern template class BlockMapEkfSlam<PlanarModel>;
extern template class BlockMapEkfSlam<MonobotModel>;

}  // namespace credence
