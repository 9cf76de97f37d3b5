#pragma once

#include <algorithm>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// Where each state of the columns stands in a step, whose `states` are in an order of its own; −1 for one
/// that it has not.
inline void find_places(const std::vector<Index>& columns, const std::vector<Index>& states,
                        std::vector<Index>& places) {
  places.clear();
  for (const Index state : columns) {
    const auto found = std::ranges::find(states, state);
    places.push_back(found == states.end() ? Index{-1} : static_cast<Index>(found - states.begin()));
  }
}

}  // namespace credence::internal
