#pragma once

#include <cstdint>

#include "analysis/studies/selftest_workers.h"

namespace credence::internal {

/// Work items of calibrate.
std::int64_t calibration_work(const SelftestOptions& options);

/// Adds the false-alarm rates on exact filters to `result`: of every shipped test, of stopping, of a
/// sweep and of single runs; and of what is often done instead.
void calibrate(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result);

}  // namespace credence::internal
