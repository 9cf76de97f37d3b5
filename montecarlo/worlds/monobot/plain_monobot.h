#pragma once

#include <cstdint>
#include <random>
#include <span>

#include "core/types.h"
#include "montecarlo/engine/moments.h"

namespace credence::internal {

/// The textbook loop that the lanes of LinearSimulator are measured against: a Kalman filter with fixed-size
/// matrices in every run ([Vidal-Calleja 2004], eqs (3)-(10), Joseph form), its NEES and NIS by Cholesky
/// solves, one normal at a time from the standard library.
///
/// The partially observable monobot with Q = R = 0.1 and P0 = I; one step for each of `nees` and `nis`, to
/// which every run adds its own. Throws std::invalid_argument for spans of different lengths and for
/// landmarks other than 1, 2 and 5.
void run_plain_monobot(Index landmarks, std::int64_t runs, std::mt19937_64& generator,
                       std::span<Moments> nees, std::span<Moments> nis);

}  // namespace credence::internal
