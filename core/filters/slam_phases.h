#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/filters/landmark_table.h"
#include "core/linear_algebra/matrix_buffer.h"
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
  bool ok = true;            ///< false: S was not positive definite; the filter is not to be used any more
  double nis = 0.0;          ///< νᵀ S⁻¹ ν of the batch, 0 if nothing known was seen
  Index dof = 0;             ///< dimension of ν: known landmarks and anchors seen × kMeasurement
  Index initialised = 0;     ///< landmarks seen for the first time
  double trace_prior = 0.0;  ///< tr P after inflation, before the update
  bool converged = true;     ///< an iteration, of the exact minimal trace or of Gauss-Newton, has settled
};

}  // namespace credence

namespace credence::internal {

/// Throws std::invalid_argument for a landmark that is there twice, whose information would count double.
template <class Model>
void require_each_once(std::span<const Observation<Model>> batch) {
  for (std::size_t i = 1; i < batch.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (batch[i].landmark == batch[j].landmark) throw_twice(batch[i].landmark);
    }
  }
}

/// The phases of a step of EKF-SLAM with known association that are the same however P is held: linearisation
/// at the estimate, and initialisation of what is seen for the first time.
///
/// x = [pose; landmarks in the order of first observation]. What derives from it holds x and P, predicts and
/// corrects.
template <class Model>
class SlamPhases {
 public:
  static constexpr int kPose = Model::kPose, kControl = Model::kControl;
  static constexpr int kLandmark = Model::kLandmark, kMeasurement = Model::kMeasurement;
  using PoseVector = Eigen::Matrix<double, kPose, 1>;
  using PoseMatrix = Eigen::Matrix<double, kPose, kPose>;
  using ControlVector = Eigen::Matrix<double, kControl, 1>;
  using ControlMatrix = Eigen::Matrix<double, kControl, kControl>;
  using LandmarkVector = Eigen::Matrix<double, kLandmark, 1>;
  using LandmarkMatrix = Eigen::Matrix<double, kLandmark, kLandmark>;
  using MeasurementVector = Eigen::Matrix<double, kMeasurement, 1>;
  using MeasurementMatrix = Eigen::Matrix<double, kMeasurement, kMeasurement>;

  Model& model() { return model_; }
  /// Their numbers, in the order of the state.
  std::span<const int> landmarks() const { return table_.ids(); }
  /// Where landmark `id` starts in the state, −1 if it is not there.
  Index offset_of(int id) const { return table_.offset_of(id); }
  BlockLayout layout() const {
    return {.vehicle = kPose, .landmark = kLandmark, .landmarks = std::ssize(table_.ids())};
  }
  VectorRef innovation() const { return nu_.vector(); }            ///< ν of the last update
  MatrixRef innovation_covariance() const { return S_.matrix(); }  ///< its S

  struct MotionPart {  ///< of a predict: F, and G Q Gᵀ
    PoseMatrix F, noise;
  };
  struct Row {          ///< Jacobian of one measurement: the vehicle's columns and those of its landmark
    Index offset = -1;  ///< of the landmark in the state, −1: an anchor
    Eigen::Matrix<double, kMeasurement, kPose> H_r;
    Eigen::Matrix<double, kMeasurement, kLandmark> H_l;
  };
  struct Placed {  ///< a new landmark: J_r, and J_z R J_zᵀ
    Eigen::Matrix<double, kLandmark, kPose> J_r;
    LandmarkMatrix noise;
  };
  const MotionPart& motion() const { return motion_; }        ///< of the last predict
  std::span<const Row> rows() const { return rows_; }         ///< of the last update
  std::span<const Placed> placed() const { return placed_; }  ///< by the last update, at the end of the state
  const MeasurementMatrix& measurement_noise() const { return R_; }  ///< R of one measurement

 protected:
  SlamPhases(Model model, const ControlMatrix& Q, const MeasurementMatrix& R,
             std::span<const Anchor<Model>> anchors)
      : model_(std::move(model)), Q_(Q), R_(R), table_(anchors) {}

  /// Innovations and Jacobians of what is known, into ν and the rows; `position_of` gives the landmark at an
  /// offset of the state.
  template <class PositionOf>
  void linearise(std::span<const Observation<Model>> observations, const PoseVector& pose,
                 PositionOf position_of) {
    require_each_once(observations);
    rows_.clear();
    placed_.clear();
    auto nu = nu_.resize(kMeasurement * static_cast<Index>(observations.size()));
    for (const Observation<Model>& o : observations) {
      const LandmarkVector* anchor = table_.anchor(o.landmark);
      const Index offset = anchor ? -1 : table_.offset_of(o.landmark);
      if (!anchor && offset < 0) continue;
      const LandmarkVector l = anchor ? *anchor : LandmarkVector(position_of(offset));
      const auto predicted = model_.predict(pose, l);
      nu.template block<kMeasurement, 1>(kMeasurement * std::ssize(rows_), 0) =
          model_.innovation(o.z, predicted.z);
      rows_.push_back({offset, predicted.H_r, predicted.H_l});
    }
    nu_.resize(kMeasurement * std::ssize(rows_));  // leaves the first of them as they are
  }

  /// Hands over position, J_r and covariance J_r P_rr J_rᵀ + J_z R J_zᵀ of every new landmark, and returns
  /// how many there are.
  template <class Append>
  Index initialise(std::span<const Observation<Model>> observations, const PoseVector& pose,
                   const PoseMatrix& P_rr, Append append) {
    Index count = 0;
    for (const Observation<Model>& o : observations) {
      if (table_.is_known(o.landmark)) continue;
      const auto placed = model_.place(pose, o.z);
      const LandmarkMatrix noise = placed.J_z * R_ * placed.J_z.transpose();
      const LandmarkMatrix own = placed.J_r * P_rr * placed.J_r.transpose() + noise;
      placed_.push_back({placed.J_r, noise});
      table_.append(o.landmark);
      append(placed.position, placed.J_r, own);
      ++count;
    }
    return count;
  }

  Model model_;
  ControlMatrix Q_;
  MeasurementMatrix R_;
  LandmarkTable<Model> table_;
  // Of the last step; kept to be read and so that a step allocates nothing.
  MotionPart motion_;
  std::vector<Row> rows_;
  std::vector<Placed> placed_;
  MatrixBuffer nu_, S_;
};

}  // namespace credence::internal
