#include "datasets/replay/replay_slam.h"

#include <algorithm>
#include <limits>

#include "core/filters/estimators/estimators.h"
#include "core/linear_algebra/cholesky.h"
#include "datasets/replay/replay_model.h"

namespace credence::internal {
namespace {

double nis_of(const RangeBearing& innovation, const Eigen::Matrix2d& S) {
  const Eigen::LLT<Eigen::Matrix2d> factor(S);
  return factor.info() == Eigen::Success ? factor.matrixL().solve(innovation).squaredNorm()
                                         : std::numeric_limits<double>::infinity();
}

std::vector<Anchor<ReplayModel>> anchors_of(const ReplaySlamInputs& inputs) {
  std::vector<Anchor<ReplayModel>> result;
  result.reserve(inputs.anchors.size());
  for (const ReplayAnchor& anchor : inputs.anchors) result.push_back({anchor.landmark, anchor.position_m});
  return result;
}

/// EKF-SLAM with inflation and anchors, its Jacobians at the estimates or at the truth.
class EkfReplay final : public ReplaySlam {
 public:
  EkfReplay(const ReplaySettings& settings, const ReplaySlamInputs& inputs)
      : R_(inputs.R),
        survey_m_(inputs.survey_m),
        looks_at_truth_(inputs.looks_at_truth),
        filter_(ReplayModel{{inputs.vehicle, 0.0}, {}}, inputs.Q, inputs.R,
                {settings.filter.inflation, settings.filter.solution, {}}, anchors_of(inputs)) {
    for (const ReplayAnchor& anchor : inputs.anchors) anchors_.push_back(anchor.landmark);
  }

  void reset(const Pose& pose, const Eigen::Matrix3d& P) override {
    filter_.reset(pose, P);
    if (looks_at_truth_) filter_.model().truth = ReplayTruthPoint{pose, pose, survey_m_, {}};
  }

  void predict(const Control& u, double dt_s, const std::optional<Pose>& truth) override {
    filter_.model().dt_s = dt_s;
    if (auto& point = filter_.model().truth) {
      point->from = point->to;
      point->to = truth.value();
    }
    filter_.predict(u);
  }

  UpdateResult update(Batch observations) override {
    std::vector<Observation<ReplayModel>> batch;
    for (const auto& o : observations) batch.push_back({o.landmark, o.z});
    if (auto& point = filter_.model().truth) {
      point->observations.clear();
      for (const auto& o : observations) {
        if (is_known(o.landmark)) point->observations.push_back(o.landmark);
      }
      filter_.model().next_observation = 0;
    }
    return filter_.update(batch);
  }

  void prepare_to_judge() override { prior_ = filter_.inflated_prior(); }

  Compatibility judge(const RangeBearing& z, int landmark) override {
    const Index offset = filter_.offset_of(landmark);
    const Point& surveyed = survey_m_[static_cast<std::size_t>(landmark) % survey_m_.size()];
    PredictedRangeBearing expected = predict_range_bearing(
        filter_.pose(), offset >= 0 ? Point(filter_.state().segment<2>(offset)) : surveyed);
    if (const auto& point = filter_.model().truth) {
      const auto at = predict_range_bearing(point->to, surveyed);
      expected.H_r = at.H_r;
      expected.H_l = at.H_l;
    }
    Compatibility result;
    result.innovation = range_bearing_innovation(z, expected.z);
    const Eigen::Matrix<double, 2, 3> PHr = expected.H_r * prior_.topLeftCorner<3, 3>();
    result.S = PHr * expected.H_r.transpose() + R_;
    if (offset >= 0) {
      const Eigen::Matrix2d cross = expected.H_r * prior_.block(0, offset, 3, 2) * expected.H_l.transpose();
      result.S += cross + cross.transpose() +
                  expected.H_l * prior_.block(offset, offset, 2, 2) * expected.H_l.transpose();
    }
    result.nis = nis_of(result.innovation, result.S);
    return result;
  }

  VectorRef state() const override { return filter_.state(); }
  const Matrix& covariance() const override { return filter_.covariance(); }
  std::span<const int> landmarks() const override { return filter_.landmarks(); }
  Index offset_of(int landmark) const override { return filter_.offset_of(landmark); }
  VectorRef innovation() const override { return filter_.innovation(); }
  MatrixRef innovation_covariance() const override { return filter_.innovation_covariance(); }
  Matrix gain() const override { return filter_.gain(); }

 private:
  bool is_known(int landmark) const {
    return filter_.offset_of(landmark) >= 0 || std::ranges::find(anchors_, landmark) != anchors_.end();
  }

  Eigen::Matrix2d R_;
  std::vector<Point> survey_m_;
  bool looks_at_truth_;
  std::vector<int> anchors_;
  EkfSlam<ReplayModel> filter_;
  Matrix prior_;
};

/// Any estimator of the list; the covariance is its own, in the plane.
class EstimatorReplay final : public ReplaySlam {
 public:
  EstimatorReplay(const ReplaySettings& settings, const ReplaySlamInputs& inputs)
      : kind_(estimator_kind(settings.filter.estimator)), survey_m_(inputs.survey_m) {
    EstimatorSettings told;
    told.model.vehicle = inputs.vehicle;
    told.sensor.kind = LandmarkSensorKind::range_bearing;
    told.Q = inputs.Q;
    told.R = inputs.R;
    told.landmarks = std::ssize(survey_m_);
    filter_ = kind_.make(told);
    trial_ = kind_.make(told);
  }

  void reset(const Pose& pose, const Eigen::Matrix3d& P) override {
    filter_->reset(pose, P);
    truth_ = {pose, pose, survey_m_};
    P_ = filter_->plane_covariance();
  }

  void predict(const Control& u, double dt_s, const std::optional<Pose>& truth) override {
    truth_.before = truth_.now;
    truth_.now = truth.value_or(truth_.now);
    filter_->set_interval(dt_s);
    filter_->predict(u, truth_);
    P_ = filter_->plane_covariance();
  }

  UpdateResult update(Batch observations) override {
    const UpdateResult result = filter_->update(observations, truth_);
    P_ = filter_->plane_covariance();
    return result;
  }

  void prepare_to_judge() override {}

  Compatibility judge(const RangeBearing& z, int landmark) override {
    kind_.assign(*trial_, *filter_);
    const Observation<PlanarModel> observation{landmark, z};
    const UpdateResult result = trial_->judge({&observation, 1}, truth_);
    if (!result.ok) return {.nis = std::numeric_limits<double>::infinity()};
    return {trial_->innovation(), trial_->innovation_covariance(), result.nis};
  }

  VectorRef state() const override { return filter_->state(); }
  const Matrix& covariance() const override { return P_; }
  std::span<const int> landmarks() const override { return filter_->landmarks(); }
  Index offset_of(int landmark) const override { return filter_->offset_of(landmark); }
  VectorRef innovation() const override { return filter_->innovation(); }
  MatrixRef innovation_covariance() const override { return filter_->innovation_covariance(); }
  Matrix gain() const override { return filter_->gain(); }

 private:
  const EstimatorKind& kind_;
  std::vector<Point> survey_m_;
  std::unique_ptr<SlamEstimator> filter_, trial_;
  PlanarTruth truth_;
  Matrix P_;
};

}  // namespace

std::unique_ptr<ReplaySlam> make_replay_slam(const ReplaySettings& settings, const ReplaySlamInputs& inputs) {
  if (settings.filter.estimator == "ekf") return std::make_unique<EkfReplay>(settings, inputs);
  return std::make_unique<EstimatorReplay>(settings, inputs);
}

}  // namespace credence::internal
