#pragma once

#include <string>

namespace credence::internal {

/// What pages call a log or a folder of logs: its own name without an ending, however it was named ("logs/",
/// "./logs", "."). Empty for the root.
std::string log_name(const std::string& path);

}  // namespace credence::internal
