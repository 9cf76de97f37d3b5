#include "core/filters/nees_along_run.h"

#include <stdexcept>

#include "core/linear_algebra/logarithm.h"

namespace credence::internal {

template <class Model>
NeesAlongRun<Model>::NeesAlongRun(const MeasurementMatrix& R) : root_of_R_(R) {
  if (root_of_R_.info() != Eigen::Success) {
    throw std::invalid_argument("NeesAlongRun: R must be positive definite");
  }
  log_R_ = log_determinant_of_factor(root_of_R_.matrixLLT());
  reset(PoseMatrix::Identity());
}

template <class Model>
void NeesAlongRun<Model>::reset(const PoseMatrix& P) {
  Sigma_ = P;
  A_.resize(kPose, 0);
  w_.resize(0);
  map_error_.resize(0);
  q_.setZero();
  map_log_determinant_ = 0.0;
}

template <class Model>
void NeesAlongRun<Model>::step(const Filter& filter, const PoseVector& prior, const VectorRef& error,
                               double log_determinant) {
  const auto& [F, noise] = filter.motion();
  const PoseMatrix moved = F * Sigma_ * F.transpose() + noise;
  Sigma_ = 0.5 * (moved + moved.transpose());
  for (Index i = 0; i < A_.cols(); ++i) A_.col(i) = (F * A_.col(i)).eval();
  if (!filter.rows().empty()) {
    set_residual(prior);
    correct(filter, prior);
    map_log_determinant_ += static_cast<double>(filter.rows().size()) * log_R_ - log_determinant;
  }
  const PoseVector pose = error.template head<kPose>();
  map_error_ = error.segment(kPose, A_.cols());
  set_residual(pose);
  for (const typename Filter::Placed& placed : filter.placed()) {
    append(placed, pose, error.template segment<kLandmark>(kPose + A_.cols()));
  }
}

template <class Model>
void NeesAlongRun<Model>::set_residual(const PoseVector& pose) {
  q_ = pose;
  for (Index i = 0; i < A_.cols(); ++i) q_ += A_.col(i) * map_error_[i];
}

template <class Model>
void NeesAlongRun<Model>::correct(const Filter& filter, const PoseVector& prior) {
  tells_.clear();
  for (std::size_t i = 0; i < filter.rows().size(); ++i) {
    const auto& [offset, H_r, H_l] = filter.rows()[i];
    MeasurementVector s = H_r * prior + filter.innovation().template segment<kMeasurement>(
                                            kMeasurement * static_cast<Index>(i));
    if (offset >= 0) s += H_l * map_error_.template segment<kLandmark>(offset - kPose);
    tells_.push_back(
        {root_of_R_.matrixL().solve(H_r), root_of_R_.matrixL().solve(H_l), root_of_R_.matrixL().solve(s)});
  }
  add_to_pose(std::span<const Told<kMeasurement>>(tells_));
  for (std::size_t i = 0; i < tells_.size(); ++i) {
    const Index offset = filter.rows()[i].offset;
    if (offset >= 0) add_to_landmark(tells_[i], offset - kPose);
  }
}

// A landmark l = g(x, z) measures 0 = J_r e_r − e_l with the noise J_z R J_zᵀ.
template <class Model>
void NeesAlongRun<Model>::append(const typename Filter::Placed& placed, const PoseVector& pose,
                                 const LandmarkVector& landmark) {
  const auto& [J_r, noise] = placed;
  const Eigen::LLT<LandmarkMatrix> root(noise);
  const LandmarkVector s = J_r * pose - landmark;
  const Told<kLandmark> told{root.matrixL().solve(J_r), root.matrixL().solve(-LandmarkMatrix::Identity()),
                             root.matrixL().solve(s)};
  add_to_pose(std::span<const Told<kLandmark>>(&told, 1));
  map_log_determinant_ += log_determinant_of_factor(root.matrixLLT());
  const Index n = A_.cols();
  w_.conservativeResize(n + kLandmark);
  A_.conservativeResize(kPose, n + kLandmark);
  map_error_.conservativeResize(n + kLandmark);
  w_.template tail<kLandmark>().setZero();
  A_.template rightCols<kLandmark>().setZero();
  map_error_.template tail<kLandmark>() = landmark;
  add_to_landmark(told, n);
}

// The information A Σ⁻¹ that pose and map share stays as it is, and w = P_ff⁻¹ e_f gains A Σ⁻¹ (q − q⁺).
template <class Model>
template <int kRows>
void NeesAlongRun<Model>::add_to_pose(std::span<const Told<kRows>> told) {
  PoseGivenMap<kPose> pose{.Sigma = Sigma_, .q = q_};
  for (const auto& [H_r, H_l, tells] : told) {
    for (int i = 0; i < kRows; ++i) map_log_determinant_ += natural_logarithm(pose.add(H_r.row(i), tells[i]));
  }
  Sigma_ = pose.Sigma;
  q_ = pose.q;
  for (Index i = 0; i < A_.cols(); ++i) {
    w_[i] += A_.col(i).dot(pose.t);
    A_.col(i) = (pose.C.transpose() * A_.col(i)).eval();
  }
}

template <class Model>
template <int kRows>
void NeesAlongRun<Model>::add_to_landmark(const Told<kRows>& told, Index at) {
  w_.template segment<kLandmark>(at) += told.H_l.transpose() * (told.tells - told.H_r * q_);
  A_.template middleCols<kLandmark>(at) += Sigma_ * told.H_r.transpose() * told.H_l;
}

template <class Model>
bool NeesAlongRun<Model>::factor(const PoseVector& variances, double least) {
  root_.compute(Sigma_);
  if (root_.info() != Eigen::Success) return false;
  return (root_.matrixLLT().diagonal().array().square() > least * variances.array()).all();
}

template <class Model>
double NeesAlongRun<Model>::nees() const {
  return map_nees() + root_.matrixL().solve(q_).squaredNorm();
}

template <class Model>
double NeesAlongRun<Model>::log_determinant() const {
  return map_log_determinant_ + log_determinant_of_factor(root_.matrixLLT());
}

template class NeesAlongRun<PlanarModel>;
template class NeesAlongRun<MonobotModel>;

}  // namespace credence::internal
