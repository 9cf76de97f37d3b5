#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/filters/ekf_slam.h"
#include "datasets/replay/replay_settings.h"

namespace credence::internal {

/// A surveyed landmark that is no state.
struct ReplayAnchor {
  int landmark = 0;
  Point position_m = Point::Zero();
};

/// What a replay does to a filter and reads of it, whatever the filter. The covariance is that of x̂ − x.
class ReplaySlam {
 public:
  using Batch = std::span<const Observation<PlanarModel>>;

  /// ν, S and NIS of one observation.
  struct Compatibility {
    RangeBearing innovation = RangeBearing::Zero();
    Eigen::Matrix2d S = Eigen::Matrix2d::Zero();
    double nis = 0.0;  ///< infinite: S is not positive definite
  };

  virtual ~ReplaySlam() = default;

  virtual void reset(const Pose& pose, const Eigen::Matrix3d& P) = 0;
  /// `truth` where the vehicle then is, for filters that look there.
  virtual void predict(const Control& u, double dt_s, const std::optional<Pose>& truth) = 0;
  virtual UpdateResult update(Batch observations) = 0;

  /// Takes the prior that the next update will use for those that follow.
  virtual void prepare_to_judge() = 0;
  /// Of an observation, if it were of a known landmark.
  virtual Compatibility judge(const RangeBearing& z, int landmark) = 0;

  virtual VectorRef state() const = 0;
  virtual const Matrix& covariance() const = 0;
  virtual std::span<const int> landmarks() const = 0;
  virtual Index offset_of(int landmark) const = 0;  ///< −1: not in the state
  virtual VectorRef innovation() const = 0;
  virtual MatrixRef innovation_covariance() const = 0;
  virtual Matrix gain() const = 0;

  Pose pose() const { return state().head<3>(); }
};

/// What a filter of a replay is told.
struct ReplaySlamInputs {
  Vehicle vehicle;
  Eigen::Matrix2d Q, R;
  std::vector<ReplayAnchor> anchors;
  std::vector<Point> survey_m;
  bool looks_at_truth = false;  ///< Jacobians there
};

/// The filter that the settings ask for: EkfSlam with its inflation and anchors for "ekf", else an estimator
/// of core/filters/estimators.
std::unique_ptr<ReplaySlam> make_replay_slam(const ReplaySettings& settings, const ReplaySlamInputs& inputs);

}  // namespace credence::internal
