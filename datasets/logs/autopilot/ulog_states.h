#pragma once

#include <filesystem>

#include "datasets/logs/log_format.h"

namespace credence::internal {

/// The topic of a simulated flight that holds the truth: --truth-topic.
inline constexpr std::string_view kUlogTruth = "vehicle_local_position_groundtruth";

/// Judges velocity and position of estimator_states against the truth of a simulated flight, every component
/// by itself, as the log holds variances alone: north, east, down.
///
/// The states are those of PX4's estimator: velocity in 4 to 6, position in 7 to 9, and the variances there
/// or, in logs of the error state (one fewer than states: 24 of 25, or 23 of 24), one place before.
/// Positions, or heights, are left out where the origins of estimate and truth are not both in the log.
/// Throws DataError, and std::invalid_argument for an instance that is not there.
void judge_ulog_states(const std::filesystem::path& file, const LogReadOptions& options, LogSink& sink);

}  // namespace credence::internal
