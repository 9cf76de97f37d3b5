#pragma once

#include <span>
#include <vector>

#include "datasets/logs/pose_facts.h"
#include "datasets/logs/trajectory_errors.h"

namespace credence::internal {

/// The time τ, the same for all rows, for which the truth at t + τ fits the estimates at t best:
///
///   τ̂ = argmin Σ_k e_k(τ)ᵀ P_k⁻¹ e_k(τ),  |τ| ≤ 1 s,  the truth aligned anew for every τ where it is
///   aligned.
///
/// The interval rests neither on P being right nor on errors that are independent in time. With
/// v_k = −de_k/dτ the influence of a row on τ̂ is q_k = v_kᵀ P_k⁻¹ e_k / mean(vᵀ P⁻¹ v), whose averages over
/// ten equal stretches of the log are nearly independent (batch means): τ̂ ± t(9) s/√10. There is none, with
/// the reason, where a stretch is shorter than ten correlation times of q, as in test_single_run, where
/// nothing moves enough, and where the rows of the truth are further apart than 4/3 of the largest time
/// difference. Between its rows the truth is interpolated, also where the nearest is judged.
///
/// Not told from a time by these errors: a constant error along the motion of a body that moves at one speed,
/// as a wrong lever arm makes it.
TimeOffset find_time_offset(std::span<const EstimateSample> samples, const Trajectory& truth,
                            const TrajectoryMatching& matching, PoseErrorAxes axes, bool joint_covariance,
                            double confidence = 0.95);

/// The matching with the time offset that it asks for, told to `sink`: an estimated one that has no interval
/// as one that was fitted to the errors (TruthFit).
TrajectoryMatching with_time_offset(std::span<const EstimateSample> samples, const Trajectory& truth,
                                    TrajectoryMatching matching, PoseErrorAxes axes, bool joint_covariance,
                                    LogSink& sink);

}  // namespace credence::internal
