#pragma once

#include <string>

namespace credence::internal {

/// The JSON Schema (draft 2020-12) of a scenario file read as JSON, from the table of keys: types, bounds,
/// words, defaults, meanings with units, and which keys a world has. What only a scenario as a whole decides,
/// such as the shape of a matrix, is not in it. Ends with a newline.
std::string scenario_json_schema();

}  // namespace credence::internal
