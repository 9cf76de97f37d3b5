#pragma once

#include <string>

namespace credence::internal {

/// The command line of this process as one would type it again, "credence run a.toml --set
/// 'world.path=\"line\"'"; empty where the system does not tell.
std::string this_command();

}  // namespace credence::internal
