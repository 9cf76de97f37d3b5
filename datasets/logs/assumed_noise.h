#pragma once

#include <span>

#include "core/record/run_layout.h"
#include "core/types.h"

namespace credence::internal {

/// R of the components `kept` of an innovation. `noise`: R of all of them, or of one observation of `piece`
/// components, of which the innovation holds several that are independent; empty: not known, as R then is.
void take_assumed_noise(const Matrix& noise, Index piece, std::span<const Index> kept, Matrix& R);

/// What a log of innovations of up to `measurements` components says of R: that of all of them, or of one
/// observation; empty where it is not known.
Matrix assumed_noise(const Sensor& sensor, Index measurements);

}  // namespace credence::internal
