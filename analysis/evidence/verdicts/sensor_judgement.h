#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "analysis/evidence/verdicts/judgement.h"
#include "analysis/evidence/verdicts/series_verdicts.h"

namespace credence::internal {

/// Why a test is not made.
inline constexpr std::string_view kLasting =
    "the innovations are correlated for too long, or in part over whole runs";

/// The verdict on the NIS of one sensor, whose steps are `nis`, of innovations that are so correlated.
ConsistencyVerdict judge_sensor_nis(const SensorSums& sums, const std::optional<GateFound>& gate,
                                    const SquareCorrelation& correlation, const StepSeries& nis,
                                    double confidence);

/// Judges the innovations of one sensor over so many steps; gate: on NIS, infinity where none is known, of
/// which the innovations themselves may tell.
SensorJudgement judge_sensor(const SensorSums& sums, std::size_t steps, double confidence, double gate);

}  // namespace credence::internal
