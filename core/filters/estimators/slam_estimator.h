#pragma once

#include <span>
#include <vector>

#include "core/filters/estimators/unscented_transform.h"
#include "core/filters/slam_phases.h"
#include "core/linear_algebra/matrix_buffer.h"
#include "core/models/landmark_sensor.h"
#include "core/models/slam_model.h"
#include "core/simd/aligned_vector.h"
#include "core/simd/panel_kernel.h"
#include "core/types.h"

namespace credence::internal {

/// What an estimator of planar SLAM is told before it starts.
struct EstimatorSettings {
  PlanarModel model;  ///< how the vehicle moves by the control that the odometry reads
  LandmarkSensor sensor;
  Eigen::Matrix2d Q = Eigen::Matrix2d::Zero();  ///< covariance of the noise on the control
  Eigen::Matrix2d R = Eigen::Matrix2d::Zero();  ///< of one landmark's measurement, positive definite
  Index landmarks = 0;                          ///< most that can be seen; they are numbered from 0
  double sigma_spread = 1e-3;                   ///< α of the sigma points, in (0, 1]
  Index active_sights = 30;  ///< after so many a landmark is only considered, by the Schmidt filter
  Index window = 10;         ///< times of observations that a smoother keeps, at least 1
};

/// Where vehicle and landmarks really are. Only the ideal filter looks.
struct PlanarTruth {
  Pose before = Pose::Zero();  ///< at the step before
  Pose now = Pose::Zero();
  std::span<const Point> landmarks{};  ///< by number
};

/// The chart in which an estimator's error is Gaussian, and P is its covariance there.
enum class ErrorChart {
  plane,            ///< x̂ − x, the heading wrapped
  right_invariant,  ///< log(X̂ X⁻¹) in SE_{1+N}(2)
};

/// A filter for SLAM in the plane whose step is: predict with a control, correct with all known landmarks in
/// one batch, place those seen for the first time. What distinguishes estimators, where they linearise and
/// how a correction moves the state, are its private virtual functions.
///
/// x = [x m, y m, θ rad; landmarks in the order of first observation]. Of P only the lower triangle is kept.
/// With m measured numbers a prediction costs O(n) (O(n²) where noise enters the landmarks), a correction
/// O(n² m); neither allocates.
class SlamEstimator {
 public:
  using PoseMatrix = Eigen::Matrix3d;
  using Batch = std::span<const Observation<PlanarModel>>;

  /// Throws std::invalid_argument for a negative number of landmarks, or a spread outside (0, 1].
  explicit SlamEstimator(const EstimatorSettings& settings);
  virtual ~SlamEstimator() = default;

  /// Starts with a pose and an empty map; P is the covariance of x̂ − x.
  void reset(const Pose& pose, const PoseMatrix& P);

  /// Time update by the control that was read.
  void predict(const Control& u, const PlanarTruth& truth);

  /// Measurement update and first observations. `ok` is false when S was not positive definite, and nothing
  /// was changed. Throws std::invalid_argument for a number out of range, and for a landmark that appears
  /// twice.
  UpdateResult update(Batch observations, const PlanarTruth& truth);

  /// The measurement update alone, without first observations: what a batch would give, by NIS, innovation()
  /// and innovation_covariance(), asked of a copy that is then thrown away.
  UpdateResult judge(Batch observations, const PlanarTruth& truth);

  Index size() const { return n_; }  ///< n
  VectorRef state() const { return x_.head(n_); }
  MatrixRef covariance() const { return P_.topLeftCorner(n_, n_); }  ///< in its chart; lower triangle
  /// Where a landmark starts in the state, −1 if it is not there.
  Index offset_of(int number) const { return offsets_[static_cast<std::size_t>(number)]; }
  std::span<const int> landmarks() const { return ids_; }          ///< in the order of the state
  VectorRef innovation() const { return nu_.vector(); }            ///< ν of the last correction
  MatrixRef innovation_covariance() const { return S_.matrix(); }  ///< its S
  /// K of the last correction, n×dim ν, of the state as it was then; allocates.
  Matrix gain() const;

  virtual ErrorChart chart() const { return ErrorChart::plane; }
  /// The error of the estimate in its chart; `error` is n.
  virtual void error(const PlanarTruth& truth, Eigen::Ref<Vector> error) const;
  /// P in the chart x̂ − x, n×n; exact to first order in the error. Allocates.
  virtual Matrix plane_covariance() const;
  /// Its pose block, without allocating.
  virtual PoseMatrix plane_pose_covariance() const;

  /// The interval of the steps that follow, s.
  void set_interval(double dt_s) { settings_.model.dt_s = dt_s; }

  /// The Jacobians as the filter used them last, in its chart: the motion of the pose, and H of the last
  /// correction over the states `seen()`.
  const PoseMatrix& motion_jacobian() const { return F_; }
  MatrixRef measurement_jacobian() const { return H_.matrix(); }
  std::span<const Index> seen() const { return seen_; }
  /// Of the landmarks that the last update placed, in their order: δl = J_r δx_r + …
  std::span<const Eigen::Matrix<double, 2, 3>> placements() const { return placements_; }

 protected:
  using Jacobian = Eigen::Matrix<double, 2, 3>;

  const EstimatorSettings& settings() const { return settings_; }
  /// Says of the present update that an iteration ended before it had settled (UpdateResult::converged).
  void set_not_converged() { converged_ = false; }
  Pose pose() const { return x_.head<3>(); }
  Point landmark(Index offset) const { return x_.segment<2>(offset); }
  /// The world's number of the landmark that starts at this state.
  int number_at(Index offset) const { return ids_[static_cast<std::size_t>((offset - 3) / 2)]; }
  Vector& x() { return x_; }
  const Vector& x() const { return x_; }
  Matrix& P() { return P_; }
  PoseMatrix pose_covariance() const;
  /// P over the states seen(), full.
  Eigen::Map<Matrix> seen_covariance();

  /// P_rr ← F P_rr Fᵀ + Q_r, P_fr ← P_fr Fᵀ.
  void propagate_pose(const PoseMatrix& F, const PoseMatrix& Q_r);

  /// Room for ν, S and its factor L, and W = K L of a correction by m numbers; all but ν zero.
  struct Correction {
    Eigen::Map<Matrix> S, L, W;
  };
  Correction start_correction(Index m);

  /// Sets the rows of landmark i of the batch (from 0): ν and the blocks of H on the pose and the landmark.
  void set_rows(Index i, const Eigen::Vector2d& nu, const Jacobian& H_r, const Eigen::Matrix2d& H_l);
  void set_motion_jacobian(const PoseMatrix& F) { F_ = F; }
  /// For an estimator whose Jacobians are settled later than they are used first: those of `states`, the pose
  /// before the landmarks, and of placements, in place of what motion_jacobian() and the like would say.
  Eigen::Map<Matrix> show_jacobians(const PoseMatrix& F, std::span<const Index> states, Index rows);
  std::vector<Jacobian>& shown_placements() { return placements_; }
  Eigen::Map<Matrix> H() { return H_.matrix(); }
  Eigen::Map<Vector> nu() { return nu_.vector(); }
  /// Added to S beside R; zero unless a linearisation sets it.
  Eigen::Map<Matrix> added_covariance() { return added_covariance_.matrix(); }
  std::span<const Eigen::Vector2d> seen_z() const { return z_; }  ///< of the known landmarks of the batch

  /// F of a motion between two places, [I, J(p⁺ − p); 0, 1]: whatever the vehicle, its motion is a constant
  /// of the control turned by the heading.
  static PoseMatrix plane_motion(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  /// Sets the rows of every known landmark of the batch: ν at the estimates, H at a pose and at the place
  /// that `place_of` says of the landmark that starts at a state.
  template <class PlaceOf>
  void set_plane_rows(const Pose& pose_at, PlaceOf place_of) {
    Jacobian H_r;
    Eigen::Matrix2d H_l;
    for (std::size_t i = 0; i < z_.size(); ++i) {
      const Index offset = seen_[3 + 2 * i];
      plane_jacobian(pose_at, place_of(offset), H_r, H_l);
      set_rows(static_cast<Index>(i), innovation_of(i, pose(), landmark(offset)), H_r, H_l);
    }
  }
  /// The rows of every known landmark of the batch by sigma points of all states that it touches:
  /// `move(pose, landmark, pose_step, step)` is ⊞, `jacobian` gives H in directions without variance.
  template <class Move, class JacobianAt>
  void set_sigma_rows(UnscentedTransform& transform, Move move, JacobianAt jacobian);
  /// The Jacobians of a landmark placed at z, whose way from the vehicle is `away`: J_r = [I, J away],
  /// J_z at the estimated heading.
  void plane_placement(const Eigen::Vector2d& away, const Eigen::Vector2d& z, Jacobian& J_r,
                       Eigen::Matrix2d& J_z) const;
  /// H of one landmark at a pose and a place: D Rᵀ [−I, −J(l − p), I].
  void plane_jacobian(const Pose& pose, const Point& landmark, Jacobian& H_r, Eigen::Matrix2d& H_l) const;
  /// ẑ of one landmark at a pose and a place.
  Eigen::Vector2d predicted(const Pose& pose, const Point& landmark) const;
  Eigen::Vector2d innovation_of(std::size_t i, const Pose& pose, const Point& landmark) const {
    return settings_.sensor.innovation(z_[i], predicted(pose, landmark));
  }

 private:
  virtual void started() {}  ///< after reset; x and P are those of x̂ − x
  /// The estimated pose has moved by `motion` from `before`; moves P.
  virtual void propagate(const Pose& before, const Motion& motion, const Control& u,
                         const PlanarTruth& truth) = 0;
  /// Sets the rows of every known landmark that is seen.
  virtual void linearise(const PlanarTruth& truth) = 0;
  /// x ← x ⊞ δ.
  virtual void retract(const VectorRef& delta);
  /// δl = J_r δx_r + J_z w of a landmark just placed at z; the state holds it already, at its end.
  virtual void place(const Eigen::Vector2d& z, const PlanarTruth& truth, Jacobian& J_r, Eigen::Matrix2d& J_z);

  /// δ and W of a correction, P⁺ = P − W Wᵀ: moves P; may set rows of both to zero.
  virtual void apply(Eigen::Map<Matrix>& W, Eigen::Map<Vector>& delta);
  /// Corrects x and P by the rows that are set, and fills ν, S and W; false: S is not positive definite, and
  /// nothing was changed.
  virtual bool correct(UpdateResult& result);
  /// After a batch was used, with its first observations; false: a factorisation failed, and the estimates
  /// are not to be used.
  virtual bool refine(Batch, const PlanarTruth&) { return true; }

  void collect(Batch observations);
  void append(const Observation<PlanarModel>& observation, const PlanarTruth& truth);

  EstimatorSettings settings_;
  Index n_ = 3;
  Vector x_;
  Matrix P_;
  std::vector<int> ids_;
  std::vector<Index> offsets_;  ///< by number; −1: not in the state

  std::vector<Index> seen_;  ///< the states that the batch touches, the pose first
  std::vector<Eigen::Vector2d> z_;
  bool converged_ = true;  ///< of the present update
  PoseMatrix F_ = PoseMatrix::Identity();
  std::vector<Jacobian> placements_;
  const PanelKernel* kernel_ = &panel_kernel(best_instruction_set());
  AlignedVector W_panels_;  ///< W as its kernel takes it
  MatrixBuffer nu_, H_, S_, added_covariance_, L_, W_, columns_, seen_P_, whitened_, delta_;
};

template <class Move, class JacobianAt>
void SlamEstimator::set_sigma_rows(UnscentedTransform& transform, Move move, JacobianAt jacobian) {
  const Index m = 2 * std::ssize(z_);
  for (Index i = 0; 2 * i < m; ++i) {
    nu().segment<2>(2 * i) = innovation_of(static_cast<std::size_t>(i), pose(),
                                           landmark(seen_[static_cast<std::size_t>(3 + 2 * i)]));
  }
  transform.take(seen_covariance(), m, settings_.sigma_spread,
                 [&](const VectorRef& step, Eigen::Ref<Vector> y) {
                   for (Index i = 0; 2 * i < m; ++i) {
                     const Point l = landmark(seen_[static_cast<std::size_t>(3 + 2 * i)]);
                     Pose moved_pose = pose();
                     Point moved = l;
                     move(moved_pose, moved, step.head<3>(), step.segment<2>(3 + 2 * i));
                     y.segment<2>(2 * i) =
                         settings_.sensor.innovation(predicted(moved_pose, moved), predicted(pose(), l));
                   }
                 });
  nu() -= transform.shift();
  added_covariance() = transform.curvature();
  auto D = transform.D();
  const auto root = transform.root();
  if ((root.diagonal().array() == 0.0).any()) {  // where nothing is spread
    for (Index i = 0; 2 * i < m; ++i) {
      Jacobian H_r;
      Eigen::Matrix2d H_l;
      jacobian(pose(), landmark(seen_[static_cast<std::size_t>(3 + 2 * i)]), H_r, H_l);
      for (Index j = 0; j < root.cols(); ++j) {
        if (root(j, j) != 0.0) continue;
        const bool own = j == 3 + 2 * i || j == 4 + 2 * i;
        D.block<2, 1>(2 * i, j) = j < 3 ? Point(H_r.col(j))
                                  : own ? Point(H_l.col(j - 3 - 2 * i))
                                        : Point(0.0, 0.0);
      }
    }
  }
  divide_by_root(D, root);
  H() = D;
}

}  // namespace credence::internal
