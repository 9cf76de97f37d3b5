#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "core/filters/slam_phases.h"
#include "core/linear_algebra/cholesky.h"
#include "core/models/slam_model.h"
#include "core/types.h"

namespace credence::internal {

/// The law of the pose given the map, e_r | e_f ~ N(−Aᵀ e_f, Σ) with q = e_r + Aᵀ e_f, under measurements,
/// scalar by scalar and without Σ⁻¹.
template <int kPose>
struct PoseGivenMap {
  using Vector = Eigen::Matrix<double, kPose, 1>;
  using Square = Eigen::Matrix<double, kPose, kPose>;

  Square Sigma;
  Vector q;
  Square C = Square::Identity();  ///< A⁺ = A C
  Vector t = Vector::Zero();      ///< w⁺ = w + A t

  /// A measurement of variance one that tells h e_r + l e_l + ν = `told`, h its part of the pose: with g = Σ
  /// h, Σ⁺ = Σ − g gᵀ/s and Σ⁻¹ Σ⁺ = I − h gᵀ/s. Returns s = 1 + hᵀ g.
  double add(const Vector& h, double told) {
    const Vector g = Sigma * h, Ch = C * h;
    const double s = 1.0 + h.dot(g), gain = (h.dot(q) - told) / s;
    t += gain * Ch;
    C -= Ch * (g / s).transpose();
    q -= gain * g;
    Sigma -= g * (g / s).transpose();
    return s;
  }
};

/// Two ways to the same NEES of n states may differ by so much of n + eᵀ P⁻¹ e.
inline constexpr double kMostNeesDifference = 1e-8;
/// Whether NEES along a run is that by a factor of P.
inline bool agree(double along_run, double by_factor, Index n) {
  return std::abs(along_run - by_factor) <= kMostNeesDifference * (static_cast<double>(n) + by_factor);
}

/// eᵀ P⁻¹ e of EKF-SLAM from step to step in O(n), without a factor of P (theory, section 7, "NEES along a
/// run").
///
/// The law that the filter claims for e = [e_r; e_f] is kept as that of the map and that of the pose given
/// the map, e_r | e_f ~ N(−Aᵀ e_f, Σ). With w = P_ff⁻¹ e_f and q = e_r + Aᵀ e_f
///
///   eᵀ P⁻¹ e = e_fᵀ w + qᵀ Σ⁻¹ q.
///
/// A motion changes A and Σ alone; a correction adds Hᵀ R⁻¹ H to P⁻¹, whatever H and ν were, and so does a
/// new landmark. Any other change of P, as by inflation, ends it. A singular Σ, as of an exact start, is no
/// obstacle, but there is no value until it is regular.
template <class Model>
class NeesAlongRun {
 public:
  using Filter = SlamPhases<Model>;
  using PoseVector = typename Filter::PoseVector;
  using PoseMatrix = typename Filter::PoseMatrix;
  using MeasurementMatrix = typename Filter::MeasurementMatrix;

  /// R is that of one measurement, positive definite: else std::invalid_argument.
  explicit NeesAlongRun(const MeasurementMatrix& R);

  /// Starts with an empty map and the covariance P of the pose.
  void reset(const PoseMatrix& P);

  /// The step that `filter` has made: `prior` is the error of the pose as predicted, `error` (n) that of the
  /// whole state now, `log_determinant` ln det S, 0 where nothing was measured. Some 30 n multiply-adds.
  void step(const Filter& filter, const PoseVector& prior, const VectorRef& error, double log_determinant);

  /// Factors Σ = L Lᵀ. False, and there is no value, unless every L_ii² is more than `least` of the variance
  /// of the pose.
  bool factor(const PoseVector& variances, double least);

  double map_nees() const { return map_error_.dot(w_); }  ///< e_fᵀ P_ff⁻¹ e_f
  double nees() const;                                    ///< eᵀ P⁻¹ e
  double log_determinant() const;                         ///< ln det P

 private:
  static constexpr int kPose = Filter::kPose, kLandmark = Filter::kLandmark;
  static constexpr int kMeasurement = Filter::kMeasurement;
  using LandmarkMatrix = typename Filter::LandmarkMatrix;
  using LandmarkVector = typename Filter::LandmarkVector;
  using MeasurementVector = typename Filter::MeasurementVector;
  using PoseRows = Eigen::Matrix<double, kPose, Eigen::Dynamic>;

  void correct(const Filter& filter, const PoseVector& prior);
  void append(const typename Filter::Placed& placed, const PoseVector& pose, const LandmarkVector& landmark);
  /// q = e_r + Aᵀ e_f.
  void set_residual(const PoseVector& pose);
  /// A measurement, white and of unit variance: its Jacobians, and H e + ν.
  template <int kRows>
  struct Told {
    Eigen::Matrix<double, kRows, kPose> H_r;
    Eigen::Matrix<double, kRows, kLandmark> H_l;
    Eigen::Matrix<double, kRows, 1> tells;
  };
  /// All that measurements tell but of their own landmarks.
  template <int kRows>
  void add_to_pose(std::span<const Told<kRows>> told);
  /// What one tells of its landmark, `at` in the map, Σ and q being those after it.
  template <int kRows>
  void add_to_landmark(const Told<kRows>& told, Index at);

  Eigen::LLT<MeasurementMatrix> root_of_R_;
  double log_R_ = 0.0;
  PoseMatrix Sigma_;
  PoseRows A_;  ///< Aᵀ, n_r×n_f
  Vector w_, map_error_;
  PoseVector q_;
  double map_log_determinant_ = 0.0;       ///< ln det P_ff
  Eigen::LLT<PoseMatrix> root_;            ///< of Σ
  std::vector<Told<kMeasurement>> tells_;  ///< of the step
};

extern template class NeesAlongRun<PlanarModel>;
extern template class NeesAlongRun<MonobotModel>;

}  // namespace credence::internal
