#pragma once

#include <string>
#include <string_view>

namespace credence::internal {

/// What differs between two canonical texts of a scenario or sweep, key by key, for a reader:
///
///   - world.landmarks = 2
///   + world.landmarks = 3
///
/// with - for `stored` and + for `asked`; empty when nothing does. study.runs, study.stop and
/// study.confidence are passed over: more runs extend a study, and a verdict is made from what is stored.
std::string scenario_difference(std::string_view stored, std::string_view asked);

}  // namespace credence::internal
