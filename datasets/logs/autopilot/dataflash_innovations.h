#pragma once

#include "datasets/logs/log_format.h"

namespace credence::internal {

/// --input dataflash: the innovations that ArduPilot's estimators EKF3 or EKF2 wrote into a flight log.
///
/// The log has innovations (XKF3, NKF3) in steps of 0.01 and, of each group of them, the square root of its
/// test ratio (XKF4, NKF4) in steps of 0.01, ratio = Σν² / (gate² ΣS) with the gate of the log's parameters.
/// Of a group of m components m Σν² / ΣS is then known, whose mean is m, and is taken for the NIS of
/// innovations that have the direction of ν and S = I: exact for one component, and for several with equal
/// variances. Of several cores one is judged, the first or LogReadOptions::instance.
LogFormat dataflash_format();

}  // namespace credence::internal
