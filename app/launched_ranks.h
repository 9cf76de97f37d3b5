#pragma once

#include "montecarlo/engine/ranks.h"

namespace credence::internal {

/// The processes that mpirun or srun started together with this one, null where it was started alone. The
/// first call joins them, through a module beside the program (app/mpi), and from then on a helper's output
/// goes nowhere: it tells rank 0 what is wrong.
///
/// Throws std::runtime_error where others were started and cannot be joined.
Ranks* launched_ranks();

/// Leaves them; the last that the process does with them.
void leave_ranks();

}  // namespace credence::internal
