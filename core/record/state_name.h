#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/record/run_layout.h"

namespace credence::internal {

/// What a log, an array or a model says of a state in its name.
struct StateName {
  std::string name{};  ///< "attitude.yaw" of "attitude.yaw:angle"
  bool angle = false;  ///< ":angle" behind it
  std::string unit{};  ///< "m/s" of "velocity.x [m/s]", behind all else; "": not told
};

/// Takes the marks off a name. Brackets with nothing before or in them are a part of the name.
StateName state_name(std::string_view text);

/// The states of a layout with their marks: what state_name and add_named_blocks read back as the same
/// states, angles and units. Units only where these would not be known without, and then all.
std::vector<std::string> marked_states(const RunLayout& layout);

/// Throws std::invalid_argument where an angle is in another unit than rad; `source`, with which it begins,
/// says where that is told.
void require_radians(const RunLayout& layout, std::string_view source = {});

}  // namespace credence::internal
