#pragma once

#include <algorithm>
#include <span>
#include <stdexcept>
#include <utility>

#include "core/filters/delayed_covariance.h"
#include "core/filters/joseph_update.h"
#include "core/filters/sequential_update.h"
#include "core/filters/slam_phases.h"
#include "core/inflation/inflation_along_run.h"
#include "core/inflation/inflation_rule.h"
#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/matrix_buffer.h"
#include "core/linear_algebra/mirror.h"
#include "core/linear_algebra/panel_cholesky.h"
#include "core/models/slam_model.h"
#include "core/types.h"

namespace credence {

/// EKF-SLAM by eqs (3)-(10) of [Vidal-Calleja 2004]: dense covariance, known association.
///
/// x = [pose; landmarks in the order of first observation]. A step is predict(u) then update(z); covariance
/// inflation, if any, comes between the two, or within the update if the rule is sequential. A predict costs
/// O(n), an update with m measurements m³/6 + n m²/2 + n² m/2 multiply-adds. Those of the last term, a pass
/// over one triangle of P, are done for several updates together (DelayedCovariance), and when P is read, so
/// that one filter belongs to one thread.
///
/// The update is P ← P − W Wᵀ with W = P Hᵀ L⁻ᵀ and S = L Lᵀ. Its rounding is that of the prior, and relative
/// to the posterior in the measured directions that times tr(R⁻¹ S). An update with tr(R⁻¹ S) > 1e8 (a prior
/// that vague, or a singular R), or that would leave a variance negative, is done in Joseph's form instead,
/// and counted.
template <class Model>
class EkfSlam : public internal::SlamPhases<Model> {
 public:
  using Phases = internal::SlamPhases<Model>;
  using Phases::kPose, Phases::kLandmark, Phases::kMeasurement;
  using Phases::layout;
  using typename Phases::ControlMatrix;
  using typename Phases::ControlVector;
  using typename Phases::LandmarkMatrix;
  using typename Phases::LandmarkVector;
  using typename Phases::MeasurementMatrix;
  using typename Phases::PoseMatrix;
  using typename Phases::PoseVector;

  static constexpr double kMostCancellation = 1e8;  ///< of tr(R⁻¹ S), for P − W Wᵀ

  /// `Q` is the covariance of the noise on the control, `R` that of one measurement; both symmetric psd. No
  /// bit depends on the instruction set, which must be there. Throws std::invalid_argument for a sequential
  /// rule with an R that is not diagonal.
  EkfSlam(Model model, const ControlMatrix& Q, const MeasurementMatrix& R, InflationRule rule = {},
          std::span<const internal::Anchor<Model>> anchors = {},
          internal::InstructionSet set = internal::best_instruction_set())
      : Phases(std::move(model), Q, R, anchors), rule_(std::move(rule)), P_(kPose, set), factor_(set) {
    if (rule_.is_sequential() && !R.isDiagonal(0.0))
      throw std::invalid_argument("a sequential rule needs a diagonal measurement noise R");
    const Eigen::LLT<MeasurementMatrix> R_llt(R);
    R_is_definite_ = R_llt.info() == Eigen::Success;
    if (R_is_definite_) R_inverse_ = R_llt.solve(MeasurementMatrix::Identity());
    reset(PoseVector::Zero(), PoseMatrix::Zero());
  }

  /// Starts with a pose of covariance P and an empty map.
  void reset(const PoseVector& pose, const PoseMatrix& P);

  /// Starts with a pose and the landmarks `ids` in the state already: x is n, P n×n.
  ///
  /// Throws std::invalid_argument for sizes that do not match, and for a landmark that is there twice.
  void reset(VectorRef x, MatrixRef P, std::span<const int> ids);

  /// Time update: x_r ← f(x_r, u), P_rr ← F P_rr Fᵀ + G Q Gᵀ, P_rf ← F P_rf.
  void predict(const ControlVector& u);

  /// Inflation, measurement update with all known landmarks and anchors in one batch, and initialisation of
  /// the landmarks seen for the first time. Throws std::invalid_argument for a landmark that appears twice in
  /// the batch or has a negative number, and nothing is changed.
  UpdateResult update(std::span<const Observation<Model>> observations) {
    UpdateResult result;
    this->linearise(observations, pose(),
                    [this](Index offset) { return x_.template segment<kLandmark>(offset); });
    if (inflates_prior()) {
      result.converged = P_.change([this](Matrix& P) { return inflate_prior(P, inflation_).converged; });
    }
    result.trace_prior = P_.trace();
    result.dof = kMeasurement * static_cast<Index>(rows_.size());
    corrected_ = result.dof > 0 && correct(result);
    if (result.dof > 0 && !corrected_) {
      result.ok = false;
      return result;
    }
    result.initialised = initialise_into(observations);
    if (result.initialised > 0 && rule_.is_sequential()) {
      // The correlations of one new landmark are a star, for which the pairwise sum is the least trace.
      P_.change([this](Matrix& P) {
        inflate(P, layout(), rule_.inflation, InflationSolution::pairwise);
        return true;
      });
    }
    return result;
  }

  const Vector& state() const { return x_; }
  const Matrix& covariance() const { return P_.whole(); }
  /// P, of which the lower triangle counts; cheaper.
  const Matrix& lower_covariance() const { return P_.lower(); }
  PoseMatrix pose_covariance() const { return P_.vehicle_columns().template topRows<kPose>(); }
  double trace() const { return P_.trace(); }  ///< tr P
  /// Whether it adds anything to P but the noise of the motion.
  bool inflates() const { return rule_.inflation != Inflation::none || rule_.constant.size() > 0; }
  /// ln det S of the last update, which must have measured something.
  double innovation_log_determinant() const { return factor_.log_determinant(); }
  /// P with the inflation that the next update will begin with, n×n.
  Matrix inflated_prior() const {
    Matrix P = covariance();
    internal::InflationAlongRun copy = inflation_;
    inflate_prior(P, copy);
    return P;
  }
  PoseVector pose() const { return x_.template head<kPose>(); }
  /// Its K, n×dim ν with the n before initialisation, or n×0 if it corrected nothing; allocates.
  Matrix gain() const {
    if (!corrected_) return Matrix(x_.size(), 0);
    return rule_.is_sequential() ? Matrix(K_.matrix()) : factor_.gain();
  }
  Index joseph_updates() const { return joseph_updates_; }  ///< since the reset

 private:
  using Phases::table_, Phases::Q_, Phases::R_, Phases::motion_, Phases::rows_, Phases::nu_, Phases::S_;
  using typename Phases::Row;

  /// The landmarks of the state are `ids`.
  void know(std::span<const int> ids) {
    table_.reset(ids);
    inflation_.reset();
    corrected_ = false;
    joseph_updates_ = 0;
    nu_.resize(0);
    S_.resize(0, 0);
  }

  bool has_constant() const { return rule_.constant.rows() == x_.size() && x_.size() > 0; }
  /// Whether something is added to P before an update.
  bool inflates_prior() const {
    return has_constant() || (rule_.inflation != Inflation::none && !rule_.is_sequential());
  }

  /// All that is added before an update; within it a sequential rule adds the rest.
  InflationStep inflate_prior(Matrix& P, internal::InflationAlongRun& along) const {
    if (has_constant()) P += rule_.constant;
    return along.apply(P, layout(), rule_);
  }

  /// P Hᵀ, n×dim ν, where factor_ takes it.
  double* project();
  void compute_innovation_covariance(const double* PHt);
  bool correct(UpdateResult& result);
  bool correct_by_joseph();
  bool sequential_correct();

  /// True if P − W Wᵀ would lose too much to rounding, or leave a variance negative: the criterion of the
  /// class.
  bool cancels() const {
    if (!R_is_definite_) return true;
    double sum = 0.0;
    for (Index i = 0; i < nu_.vector().size(); i += kMeasurement) {
      sum += R_inverse_.cwiseProduct(S_.matrix().template block<kMeasurement, kMeasurement>(i, i)).sum();
    }
    // Without a branch, several at a time.
    bool positive = true;
    const double* variances = P_.variances().data();
    for (Index i = 0; i < x_.size(); ++i) positive &= variances[i] >= squares_[i];
    return !(sum <= kMostCancellation) || !positive;
  }

  /// H, n columns.
  Eigen::Map<Matrix> jacobian() {
    auto H = H_.resize(kMeasurement * std::ssize(rows_), x_.size());
    H.setZero();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Index c = kMeasurement * static_cast<Index>(i);
      H.template block<kMeasurement, kPose>(c, 0) = rows_[i].H_r;
      if (rows_[i].offset >= 0) H.template block<kMeasurement, kLandmark>(c, rows_[i].offset) = rows_[i].H_l;
    }
    return H;
  }

  /// New landmarks with their full cross-covariances: P_lx = J_r P_rx, P_ll = J_r P_rr J_rᵀ + J_z R J_zᵀ.
  Index initialise_into(std::span<const Observation<Model>> observations);

  MeasurementMatrix R_inverse_;
  bool R_is_definite_ = false;
  InflationRule rule_;
  Vector x_;
  internal::DelayedCovariance P_;
  internal::InflationAlongRun inflation_;

  // Of the last update; kept to be read and so that a step allocates nothing.
  bool corrected_ = false;
  Index joseph_updates_ = 0;
  internal::MatrixBuffer K_, columns_, H_, r_;
  internal::PanelCholesky factor_;
  internal::JosephUpdate joseph_;
  Matrix corrected_P_;  ///< by Joseph's form
  Vector squares_, change_;
  internal::SequentialWorkspace sequential_;
};

// Not in the class: what is defined there is inline, and compiled again wherever it is called.
template <class Model>
void EkfSlam<Model>::reset(const PoseVector& pose, const PoseMatrix& P) {
  know({});
  x_.resize(kPose);
  x_.template head<kPose>() = pose;
  P_.set(P);
}

template <class Model>
void EkfSlam<Model>::reset(VectorRef x, MatrixRef P, std::span<const int> ids) {
  const Index n = kPose + kLandmark * static_cast<Index>(ids.size());
  if (x.size() != n || P.rows() != n || P.cols() != n) {
    throw std::invalid_argument("EkfSlam::reset: x and P must have the size of the pose and the landmarks");
  }
  know(ids);
  x_ = x;
  P_.set(P);
}

template <class Model>
void EkfSlam<Model>::predict(const ControlVector& u) {
  const auto motion = this->model_.move(x_.template head<kPose>(), u);
  x_.template head<kPose>() = motion.pose;
  auto P = P_.vehicle_columns();
  const PoseMatrix P_rr = P.template topRows<kPose>();
  motion_ = {motion.F, motion.G * Q_ * motion.G.transpose()};
  const PoseMatrix predicted = motion.F * P_rr * motion.F.transpose() + motion_.noise;
  const double* from[kPose];
  for (Index c = 0; c < kPose; ++c) from[c] = P.col(c).data();
  const Eigen::Matrix<double, kPose, kPose, Eigen::RowMajor> F = motion.F;
  // P_fr Fᵀ, and above it what is not used.
  factor_.combine(from, F.data(), P.rows(), {.y = P.data(), .count = kPose, .step = P.outerStride()});
  P.template topRows<kPose>() = 0.5 * (predicted + predicted.transpose());
  P_.vehicle_changed();
}

template <class Model>
double* EkfSlam<Model>::project() {
  const Index n = x_.size();
  const auto P_r = P_.vehicle_columns();
  auto columns = columns_.resize(internal::whole_panels(n), kLandmark);
  double* PHt = factor_.place(kMeasurement * std::ssize(rows_), n);
  const double* from[kPose + kLandmark];
  for (Index c = 0; c < kPose; ++c) from[c] = P_r.col(c).data();
  for (Index a = 0; a < kLandmark; ++a) from[kPose + a] = columns.col(a).data();
  Eigen::Matrix<double, kMeasurement, kPose + kLandmark, Eigen::RowMajor> H;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    const bool mapped = row.offset >= 0;
    if (mapped) P_.copy_columns(row.offset, kLandmark, columns);
    H << row.H_r, row.H_l;
    const Eigen::Matrix<double, kMeasurement, kPose, Eigen::RowMajor> H_r = row.H_r;
    factor_.combine({from, static_cast<std::size_t>(mapped ? kPose + kLandmark : kPose)},
                    mapped ? H.data() : H_r.data(), n,
                    {.y = PHt + internal::kPanelRows * kMeasurement * static_cast<Index>(i),
                     .count = kMeasurement,
                     .step = internal::kPanelRows,
                     .panel_step = factor_.solved_panel_stride()});
  }
  return PHt;
}

template <class Model>
void EkfSlam<Model>::compute_innovation_covariance(const double* PHt) {
  const Index m = kMeasurement * std::ssize(rows_);
  auto S = S_.resize(m, m);
  for (Index j = 0; j < m; ++j) {
    const auto y = [=, stride = factor_.solved_panel_stride()](Index row) {
      return PHt[row / internal::kPanelRows * stride + internal::kPanelRows * j + row % internal::kPanelRows];
    };
    for (Index k = j / kMeasurement; k < std::ssize(rows_); ++k) {
      const Row& row = rows_[static_cast<std::size_t>(k)];
      for (Index i = 0; i < kMeasurement; ++i) {
        double sum = 0.0;
        for (Index c = 0; c < kPose; ++c) sum += row.H_r(i, c) * y(c);
        for (Index a = 0; a < kLandmark && row.offset >= 0; ++a) sum += row.H_l(i, a) * y(row.offset + a);
        S(kMeasurement * k + i, j) = sum;
      }
    }
  }
  for (Index i = 0; i < S.cols(); i += kMeasurement) S.template block<kMeasurement, kMeasurement>(i, i) += R_;
  internal::mirror_lower(S);
}

template <class Model>
bool EkfSlam<Model>::correct(UpdateResult& result) {
  compute_innovation_covariance(project());
  if (!factor_.compute_placed(S_.matrix(), nu_.vector()) || !S_.matrix().allFinite()) return false;
  result.nis = factor_.whitened().squaredNorm();
  if (rule_.is_sequential()) {
    if (!sequential_correct()) return false;
  } else {
    factor_.sums(squares_, change_);
    if (cancels()) {
      if (!correct_by_joseph()) return false;
    } else {
      P_.downdate(factor_);
    }
    x_ += change_.head(x_.size());
  }
  PoseVector x_r = pose();
  this->model_.wrap_pose(x_r);
  x_.template head<kPose>() = x_r;
  return true;
}

template <class Model>
bool EkfSlam<Model>::correct_by_joseph() {
  corrected_P_ = covariance();
  auto K = K_.resize(x_.size(), nu_.vector().size());
  factor_.gain(K);
  joseph_.apply(corrected_P_, jacobian(), K, R_);
  if (!corrected_P_.allFinite() || !(corrected_P_.diagonal().minCoeff() >= 0.0)) return false;
  P_.set(corrected_P_);
  ++joseph_updates_;
  return true;
}

template <class Model>
bool EkfSlam<Model>::sequential_correct() {
  auto K = K_.resize(x_.size(), nu_.vector().size());
  auto r = r_.resize(K.cols());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    r.template block<kMeasurement, 1>(kMeasurement * static_cast<Index>(i), 0) = R_.diagonal();
  }
  const bool ok = P_.change([&](Matrix& P) {
    return internal::sequential_update(P, layout(), jacobian(), r.col(0), K, sequential_, *rule_.map_bound());
  });
  if (!ok) return false;
  x_.noalias() += K * nu_.vector();
  return true;
}

template <class Model>
Index EkfSlam<Model>::initialise_into(std::span<const Observation<Model>> observations) {
  const PoseMatrix P_rr = P_.vehicle_columns().template topRows<kPose>();
  return this->initialise(observations, pose(), P_rr,
                          [&](const auto& position, const auto& J_r, const LandmarkMatrix& own) {
                            const Index n = x_.size();
                            x_.conservativeResize(n + kLandmark);
                            x_.template tail<kLandmark>() = position;
                            const auto P_r = P_.vehicle_columns();
                            auto cross = columns_.resize(kLandmark, n);
                            cross.template leftCols<kPose>() = J_r * P_rr;
                            for (Index j = kPose; j < n; ++j) cross.col(j) = J_r * P_r.row(j).transpose();
                            P_.append(cross, 0.5 * (own + own.transpose()));
                          });
}

extern template class EkfSlam<PlanarModel>;
extern template class EkfSlam<MonobotModel>;

}  // namespace credence
