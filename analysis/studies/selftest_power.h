#pragma once

#include <cstdint>

#include "analysis/studies/selftest_workers.h"

namespace credence::internal {

/// Work items of measure_power.
std::int64_t power_work(const SelftestOptions& options);

/// Adds to `result` how well wrong filters are found and their causes named, and what stopping saves on those
/// that are clearly wrong.
void measure_power(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result);

}  // namespace credence::internal
