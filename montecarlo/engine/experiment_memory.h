#pragma once

#include "montecarlo/scenario/scenario.h"

namespace credence {

/// Bytes that the experiment of a scenario, the statistics of its runs and a bit for each chunk need at the
/// least: what is more than a machine has can be refused before it is begun.
double least_experiment_bytes(const Scenario& scenario);

/// Throws std::invalid_argument naming the keys where that is more than the machine has.
void require_experiment_memory(const Scenario& scenario);

}  // namespace credence
