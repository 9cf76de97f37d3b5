#pragma once

#include <span>
#include <string>

#include "core/record/run_layout.h"
#include "core/types.h"

namespace credence::internal {

/// What would make errors far beyond P right: a truth in another unit or with another sign than the estimate,
/// state by state, or states that are exchanged between them. Empty: nothing does, or it may be chance.
///
/// rows: P, and as further columns the error and the estimate of every state (NaN: not known). A state is far
/// off where mean e²/P > 50, and right where it is < 4 then; all that are far off must be right. That is no
/// chance where one of them moves by ten σ, or is a thousand σ from zero. Angles are left to AngleUnits.
std::string other_truth(const RunLayout& layout, std::span<const Matrix> rows);

}  // namespace credence::internal
