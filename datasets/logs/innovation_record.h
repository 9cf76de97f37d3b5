#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "analysis/tuning/innovation_tuning.h"
#include "datasets/logs/judge_logs.h"

namespace credence::internal {

/// The innovations of every sensor in the files, run by run, normalised: in the order of the files and of
/// their layouts. Of a sensor whose dimension varies those of its first one count, the others are left out
/// and counted, and so are those whose S is not positive definite, and NIS alone. Throws DataError.
std::vector<SensorRecord> read_innovations(std::span<const std::filesystem::path> files,
                                           const LogFileReader& read);

}  // namespace credence::internal
