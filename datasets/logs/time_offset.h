#pragma once

#include <functional>
#include <span>
#include <vector>

#include "datasets/logs/log_format.h"
#include "datasets/logs/pose_facts.h"
#include "datasets/logs/trajectory_errors.h"

namespace credence::internal {

/// The time τ, the same for all rows of all files, for which the truth at t + τ fits the estimates at t best:
///
///   τ̂ = argmin Σ_k e_k(τ)ᵀ P_k⁻¹ e_k(τ),  |τ| ≤ 1 s,  the truth of each file aligned anew for every τ where
///   it is aligned.
///
/// The interval rests neither on P being right nor on errors that are independent in time
/// (influence_interval.h): with v_k = −de_k/dτ the score of a row is g_k = v_kᵀ P_k⁻¹ e_k, and the
/// information of a file Σ v_kᵀ P_k⁻¹ v_k. There is none, with the reason, where a single file is too short
/// for its correlation in time, where nothing moves enough, and where the rows of the truth are further apart
/// than 4/3 of the largest time difference. Between its rows the truth is interpolated, also where the
/// nearest is judged.
///
/// Not told from a time by these errors: a constant error along the motion of a body that moves at one speed,
/// as a wrong lever arm makes it. The same value for any number of threads.
TimeOffset find_time_offset(std::span<const PosesWithTruth> files, const TrajectoryMatching& matching,
                            int threads = 1);

/// The time within ± 1 s at which `cost` is least: on a grid, whose costs `on_grid` gives, and then between
/// its points. NaN where it is at an end of the grid, or infinite all over.
double time_of_least_cost(const std::function<std::vector<double>(std::span<const double> times_s)>& on_grid,
                          const std::function<double(double time_s)>& cost);

/// What the one offset makes of the truth of the files: nothing that shows where it took at most a tenth of
/// Σ eᵀP⁻¹e away at both ends of its interval; and it is not known where the files do not have one (at 1e-4,
/// and with more than a fiftieth of Σ eᵀP⁻¹e between one and one of each).
TruthFit fit_of(const TimeOffset& offset);

/// The matching of one file with the time offset that `options` ask for, told to `sink`: its own, or that of
/// all files.
TrajectoryMatching with_time_offset(const PosesWithTruth& file, const LogReading& options, LogSink& sink);

}  // namespace credence::internal
