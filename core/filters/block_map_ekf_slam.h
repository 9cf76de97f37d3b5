#pragma once

#include <span>
#include <stdexcept>
#include <vector>

#include "core/filters/arrow_covariance.h"
#include "core/filters/block_map_state.h"
#include "core/filters/ekf_slam.h"
#include "core/filters/landmark_table.h"
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
class BlockMapEkfSlam {
 public:
  static constexpr int kPose = Model::kPose, kControl = Model::kControl;
  static constexpr int kLandmark = Model::kLandmark, kMeasurement = Model::kMeasurement;
  using PoseVector = Eigen::Matrix<double, kPose, 1>;
  using PoseMatrix = Eigen::Matrix<double, kPose, kPose>;
  using ControlVector = Eigen::Matrix<double, kControl, 1>;
  using ControlMatrix = Eigen::Matrix<double, kControl, kControl>;
  using LandmarkVector = Eigen::Matrix<double, kLandmark, 1>;
  using MeasurementMatrix = Eigen::Matrix<double, kMeasurement, kMeasurement>;

  /// `Q` is the covariance of the noise on the control, `R` that of one measurement; both symmetric, Q psd
  /// and R positive definite where it is not diagonal.
  BlockMapEkfSlam(Model model, const ControlMatrix& Q, const MeasurementMatrix& R,
                  MapBound bound = MapBound::least_trace, std::span<const Anchor<Model>> anchors = {})
      : model_(std::move(model)), Q_(Q), R_(R), bound_(bound), table_(anchors) {
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
  /// that do not match.
  void reset(VectorRef x, ArrowCovariance P, std::span<const int> ids);

  /// Time update: x_r ← f(x_r, u), P_rr ← F P_rr Fᵀ + G Q Gᵀ, P_rf ← F P_rf.
  void predict(const ControlVector& u);

  /// Measurement update with all known landmarks and anchors, linearised at the prior, with the inflation
  /// after each scalar, and initialisation of the landmarks seen for the first time.
  UpdateResult update(std::span<const Observation<Model>> observations) {
    UpdateResult result;
    result.trace_prior = map_.trace();
    map_.flush_if_crowded();
    linearise(observations);
    result.dof = kMeasurement * static_cast<Index>(rows_.size());
    if (result.dof > 0) {
      result.ok = judge(result) && map_.correct(scalars_, bound_, keep_gain_ ? &K_ : nullptr);
      if (!result.ok) return result;
      if (whiten_ && keep_gain_) unwhiten_gain();
      PoseVector x_r = map_.pose();
      model_.wrap_pose(x_r);
      map_.set_pose(x_r);
    }
    result.initialised = initialise(observations);
    return result;
  }

  const Vector& state() const {
    map_.flush();
    return map_.x();
  }
  const ArrowCovariance& covariance() const {
    map_.flush();
    return map_.covariance();
  }
  std::span<const int> landmarks() const {
    return table_.ids();
  }  ///< their numbers, in the order of the state
  PoseVector pose() const { return map_.pose(); }
  const PoseMatrix& pose_covariance() const { return map_.vehicle_covariance(); }
  /// Where the landmark at `offset` of the state is; O(1), unlike state().
  LandmarkVector position(Index offset) const { return map_.position((offset - kPose) / kLandmark); }
  BlockLayout layout() const {
    return {.vehicle = kPose, .landmark = kLandmark, .landmarks = std::ssize(table_.ids())};
  }
  Model& model() { return model_; }
  VectorRef innovation() const { return nu_.vector(); }            ///< ν of the last update
  MatrixRef innovation_covariance() const { return S_.matrix(); }  ///< its S
  /// Asks updates to write down K, which costs them O(N m²).
  void keep_gain(bool keep) { keep_gain_ = keep; }
  const Matrix& gain() const { return K_; }  ///< K of the last update, n×dim ν; empty if it is not kept

  /// Memory that grows with the map.
  std::size_t bytes() const { return map_.bytes() + table_.bytes(); }

  /// Where landmark `id` starts in the state, −1 if it is not there.
  Index offset_of(int id) const { return table_.offset_of(id); }

 private:
  using Scalar = typename BlockMapState<kPose, kLandmark>::Scalar;
  struct Row {  ///< Jacobian of one measurement
    Index measured = -1;
    Eigen::Matrix<double, kMeasurement, kPose> H_r;
    Eigen::Matrix<double, kMeasurement, kLandmark> H_l;
    Eigen::Matrix<double, kPose, kMeasurement> column;  ///< vehicle rows of P Hᵀ
  };

  void linearise(std::span<const Observation<Model>> observations);

  void append_scalars(const Row& row, Eigen::Matrix<double, kMeasurement, 1> nu) {
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
          {row.measured, H_r.row(i).transpose(), H_l.row(i).transpose(), nu[i], whiten_ ? 1.0 : R_(i, i)});
    }
  }

  /// S of the batch at the prior, and its NIS.
  bool judge(UpdateResult& result);

  void set_innovation_block(Eigen::Map<Matrix>& S, std::size_t i, std::size_t k) const {
    const Row &row = rows_[i], &other = rows_[k];
    MeasurementMatrix block = row.H_r * other.column;
    if (row.measured >= 0) {
      const auto& landmark = map_.measured(row.measured);
      block += row.H_l * (landmark.cross.transpose() * other.H_r.transpose());
      if (other.measured == row.measured) block += row.H_l * landmark.block * other.H_l.transpose();
    }
    if (i == k) block = (0.5 * (block + block.transpose()) + R_).eval();
    const Index a = kMeasurement * static_cast<Index>(i), b = kMeasurement * static_cast<Index>(k);
    S.template block<kMeasurement, kMeasurement>(a, b) = block;
    S.template block<kMeasurement, kMeasurement>(b, a) = block.transpose();
  }

  /// K is of whitened innovations L⁻¹ν: from the right by L⁻¹.
  void unwhiten_gain();

  Index initialise(std::span<const Observation<Model>> observations);

  Model model_;
  ControlMatrix Q_;
  MeasurementMatrix R_, root_ = MeasurementMatrix::Zero();  ///< R = root rootᵀ, if it is not diagonal
  bool whiten_ = false, keep_gain_ = false;
  MapBound bound_;
  LandmarkTable<Model> table_;
  mutable BlockMapState<kPose, kLandmark> map_;  ///< reading it applies what is pending

  // Of the last update; kept to be read and so that a step allocates nothing.
  std::vector<Row> rows_;
  std::vector<Scalar> scalars_;
  MatrixBuffer nu_, S_, S_root_, whitened_;
  Matrix K_;
};

// Not in the class: what is defined there is inline, and compiled again wherever it is called.
template <class Model>
void BlockMapEkfSlam<Model>::reset(const PoseVector& pose, const PoseMatrix& P) {
  ArrowCovariance arrow(kPose, kLandmark);
  arrow.set_vehicle(P);
  reset(pose, std::move(arrow), {});
}

template <class Model>
void BlockMapEkfSlam<Model>::reset(VectorRef x, ArrowCovariance P, std::span<const int> ids) {
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
  const auto motion = model_.move(map_.pose(), u);
  map_.set_pose(motion.pose);
  map_.predict(motion.F, motion.G * Q_ * motion.G.transpose());
}

template <class Model>
void BlockMapEkfSlam<Model>::linearise(std::span<const Observation<Model>> observations) {
  rows_.clear();
  scalars_.clear();
  auto nus = nu_.resize(kMeasurement * static_cast<Index>(observations.size()));
  const PoseVector x_r = pose();
  for (const Observation<Model>& o : observations) {
    const LandmarkVector* anchor = table_.anchor(o.landmark);
    const Index column = anchor ? -1 : table_.column_of(o.landmark);
    if (!anchor && column < 0) continue;
    const Index j = column / kLandmark;  // its number in the state
    const LandmarkVector l = anchor ? *anchor : map_.position(j);
    const auto predicted = model_.predict(x_r, l);
    const Eigen::Matrix<double, kMeasurement, 1> nu = model_.innovation(o.z, predicted.z);
    nus.template block<kMeasurement, 1>(kMeasurement * static_cast<Index>(rows_.size()), 0) = nu;
    Row& row = rows_.emplace_back();
    row.measured = anchor ? -1 : map_.measure(j);
    row.H_r = predicted.H_r;
    row.H_l = predicted.H_l;
    append_scalars(row, nu);
  }
  nu_.resize(kMeasurement * static_cast<Index>(rows_.size()));  // leaves the first of them as they are
}

template <class Model>
bool BlockMapEkfSlam<Model>::judge(UpdateResult& result) {
  const auto nu = nu_.vector();
  auto S = S_.resize(nu.size(), nu.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    row.column = map_.vehicle_covariance() * row.H_r.transpose();
    if (row.measured >= 0) row.column += map_.measured(row.measured).cross * row.H_l.transpose();
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

template <class Model>
Index BlockMapEkfSlam<Model>::initialise(std::span<const Observation<Model>> observations) {
  Index count = 0;
  for (const Observation<Model>& o : observations) {
    if (table_.is_known(o.landmark)) continue;
    const auto placed = model_.place(pose(), o.z);
    table_.append(o.landmark);
    map_.append(placed.position, placed.J_r,
                placed.J_r * map_.vehicle_covariance() * placed.J_r.transpose() +
                    placed.J_z * R_ * placed.J_z.transpose());
    ++count;
  }
  return count;
}

extern template class BlockMapEkfSlam<PlanarModel>;
extern template class BlockMapEkfSlam<MonobotModel>;

}  // namespace credence
