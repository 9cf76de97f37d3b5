#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/types.h"
#include "montecarlo/random/noise.h"

namespace credence::internal {

/// What is wrong with a synthetic filter, or with its log.
enum class Defect {
  none,
  process_noise_too_small,
  process_noise_too_large,
  measurement_noise_too_small,
  measurement_noise_too_large,
  wrong_dof,                 ///< claims one dof more than its state has
  unwrapped_angle,           ///< the compass innovation is not wrapped
  dropped_cross_covariance,  ///< between heading and landmark, after every update
  coloured_noise,            ///< measurement noise correlated in time
  initial_covariance,        ///< the initial error is three times larger than P0 says
  gated_innovations,         ///< only innovations within the 95 % gate are logged; P is right
  biased_measurement,        ///< a constant on the compass
  heavy_tails,               ///< a measurement in ten is three times noisier than the others; R is right
  shared_prior,              ///< both measurements are logged as sensors of their own; P is right
};

/// The defect in words.
std::string_view to_string(Defect defect);

/// What a synthetic filter assumes, relative to the truth.
struct SyntheticSetup {
  double noise_ratio = 0.0025;                                               ///< true Q/R
  double process_scale = 1.0, measurement_scale = 1.0, initial_scale = 1.0;  ///< assumed / true variance
  double logged_scale = 1.0;         ///< of the P that is logged, which the filter does not use
  bool every_third_missing = false;  ///< of the measurements
  Defect defect = Defect::none;
};

/// The setup of a defect; Q and R that are wrong show best at Q/R = 0.1.
SyntheticSetup setup_of(Defect defect);

/// A vehicle that turns, and the bearing of a landmark that stands still: x = [heading, landmark] in rad,
/// with a compass and the landmark's bearing as measurements: F = I, H = [−1 1; 1 0], 40 steps. At Q/R =
/// 0.0025 its NEES is strongly correlated in time. Linear, hence exactly consistent without a defect.
class SyntheticFilter {
 public:
  static constexpr int kRuns = NoiseSource::kLanes;
  static constexpr int kSteps = 40;
  static constexpr double kStateDof = 2.0;
  static constexpr double kInnovationDof = 2.0;

  explicit SyntheticFilter(const SyntheticSetup& setup);

  using Lanes = Eigen::Matrix<double, 2, kRuns>;  ///< one column for each run
  /// One step of all runs.
  struct Sample {
    Lanes error;       ///< estimate − truth after the update
    Lanes innovation;  ///< ν
  };
  /// Runs kRuns · block … kRuns · (block + 1) − 1, one entry for each step.
  std::vector<Sample> simulate(const NoiseSource& noise, std::int64_t block) const;

  /// NEES of every run for the errors of a step.
  Eigen::Array<double, 1, kRuns> nees(int step, const Lanes& error) const;
  /// NIS of every run for the innovations of a step.
  Eigen::Array<double, 1, kRuns> nis(int step, const Lanes& innovation) const;

  /// P after the update of a step, as the filter believes; and of every step, with its transition (I − K H)
  /// F.
  const Eigen::Matrix2d& covariance(int step) const { return steps_[static_cast<std::size_t>(step)].P; }
  std::vector<Matrix> covariances() const;
  std::vector<Matrix> transitions() const;
  const Eigen::Matrix2d& innovation_covariance(int step) const {
    return steps_[static_cast<std::size_t>(step)].S;
  }
  bool missing(int step) const { return steps_[static_cast<std::size_t>(step)].missing; }
  double assumed_measurement_variance() const;  ///< rad², of either measurement
  const SyntheticSetup& setup() const { return setup_; }

 private:
  struct Step {
    Eigen::Matrix2d P, S, K, A, inverse_factor_P, inverse_factor_S;
    bool missing = false;  ///< no measurement
  };

  SyntheticSetup setup_;
  std::vector<Step> steps_;
};

}  // namespace credence::internal
