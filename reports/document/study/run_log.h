#pragma once

#include <filesystem>
#include <string>

#include "montecarlo/engine/experiment.h"

namespace credence::internal {

/// The steps of one run before step `end` (from 1) as a log in the project's own format (docs/formats.md),
/// with the shortest decimals that read back as the same bits.
///
/// States are named vehicle and landmark1 …, in the plane vehicle.x, vehicle.y, vehicle.heading, landmark1.x
/// …, in the order of the filter's last state; what was not yet in the state is blank. The first row says
/// what is known of the filter: R, and whether it linearises or inflates. `failure` is empty or how the run
/// ended, "diverged at step 17". step_s: the time of a step, s, of which there is a column; 0: none. Throws
/// OutputError when the file cannot be written; it appears whole or not at all.
void write_run_log(const std::filesystem::path& target, const RunTrace& trace, std::size_t end,
                   const std::string& failure, double step_s = 0.0);

}  // namespace credence::internal
