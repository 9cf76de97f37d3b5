#pragma once

#include "core/types.h"

namespace credence::internal {

/// How a SLAM state x = [x_r; x_f1; …; x_fN] is cut into blocks: the vehicle first, then equal landmarks.
struct BlockLayout {
  Index vehicle = 1;    ///< n_r, the vehicle's dimension
  Index landmark = 1;   ///< d, the dimension of one landmark
  Index landmarks = 0;  ///< N, the number of landmarks in the state

  Index state_dim() const { return vehicle + landmark * landmarks; }
  Index landmark_offset(Index i) const { return vehicle + landmark * i; }
};

}  // namespace credence::internal
