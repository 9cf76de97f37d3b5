#pragma once

#include <array>
#include <vector>

#include "core/filters/estimators/ekf_estimator.h"
#include "core/linear_algebra/panel_cholesky.h"

namespace credence::internal {

/// Sliding-window smoother: the poses of the last `window` times of observations, and the map, at the least
/// squares of a prior on the oldest pose and the landmarks known by then, of the motions and of all
/// observations in the window, by Gauss-Newton. With a window as long as the run it is the batch solution.
///
/// An iteration is a Kalman filter through the window, linearised at the present estimates, that carries the
/// correlations of earlier poses with what is estimated now: the same minimum as that of the normal
/// equations ([Bell 1994]), for a singular prior too. Motions between two observations are put together in
/// the frame of the vehicle. When the window moves on, its oldest pose is marginalised: the filter's state
/// after the observations there and the motion to the next pose is the new prior, linear from then on.
///
/// It has settled once a step is below 1e-5 m and rad, mostly after a few. Where a step from the eleventh on
/// is no shorter than the one before, half of each is taken from then on; after kMostIterations the estimates
/// are where they led, and UpdateResult::converged is false.
///
/// What has entered a prior is linearised at two places, one of the prior and another of its present
/// estimate, which pretends to tell the heading. With `first_estimates` its Jacobians stay where they were
/// taken for the prior ([Dong-Si 2011]).
class SmootherEstimator final : public EkfEstimator {
 public:
  static constexpr int kPlainIterations = 10, kMostIterations = 200;

  explicit SmootherEstimator(const EstimatorSettings& settings, bool first_estimates = false);

 private:
  static constexpr std::array<Index, 3> kPoseStates = {0, 1, 2};

  /// A pose, the motion that led to it from the one before, and what was seen there.
  struct Frame {
    Pose pose;
    Pose moved;        ///< in the frame of the pose before
    PoseMatrix noise;  ///< covariance of that
    std::vector<Observation<PlanarModel>> seen;
  };

  void started() override;
  void propagate(const Pose& before, const Motion& motion, const Control& u,
                 const PlanarTruth& truth) override;
  bool refine(Batch observations, const PlanarTruth& truth) override;

  /// A share of Gauss-Newton's step from the present estimates; sets P and the next prior. Returns the
  /// largest change of the whole step, m or rad; NaN where a factorisation failed.
  double iterate(double share);
  void start_pass();
  void predict_frame(std::size_t j);
  bool correct_frame(std::size_t j);
  void place_landmark(const Observation<PlanarModel>& o, std::size_t j);
  double finish_pass(double share);
  void keep_prior();
  void move_window();
  void show_nothing() { show_jacobians(PoseMatrix::Identity(), kPoseStates, 0); }

  /// Where Jacobians are taken.
  const Pose& pose_point(std::size_t j) const;
  Point landmark_point(Index offset) const;
  /// ν, H_r and H_l of an observation from frame j.
  Eigen::Vector2d linearised(const Observation<PlanarModel>& o, std::size_t j, Index offset, Jacobian& H_r,
                             Eigen::Matrix2d& H_l) const;
  Index clone(std::size_t j) const { return width_ + 3 * static_cast<Index>(j); }
  bool is_full() const { return count_ == frames_.size(); }

  bool first_estimates_;
  Index width_;  ///< the most states there can be
  std::vector<Frame> frames_;
  std::size_t count_ = 1;      ///< frames in use; the last is now
  Pose moved_ = Pose::Zero();  ///< since the last frame, in its frame
  PoseMatrix moved_noise_ = PoseMatrix::Zero();

  /// What is known of the oldest pose and of the landmarks seen before it.
  struct Prior {
    Vector mean;
    Matrix P;
    Index size = 3;
    Pose point = Pose::Zero();                   ///< first estimate of the pose
    PoseMatrix motion = PoseMatrix::Identity();  ///< F that led to it
  };
  Prior prior_, next_;
  Vector points_;  ///< first estimates of the landmarks that a prior knows

  // Of a pass through the window: rows of the states, then of the earlier poses; columns of the states.
  Index n_ = 3;                ///< states so far
  std::size_t clones_ = 0;     ///< earlier poses so far
  Vector d_;                   ///< mean less the point of linearisation
  Matrix C_;                   ///< covariance
  PoseMatrix F_now_;           ///< of the last motion
  std::vector<Index> states_;  ///< that a frame's observations touch
  MatrixBuffer H_pass_, nu_pass_, S_pass_, W_pass_;
  PanelCholesky S_factor_;
};

}  // namespace credence::internal
