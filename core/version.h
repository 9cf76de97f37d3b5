#pragma once

#include <string>
#include <string_view>

namespace credence {

/// "0.1.0", as CMake has it.
std::string_view version();

/// The commit that was built, with a "+" if files had changed since; empty outside of a repository.
std::string_view commit();

/// "0.1.0 (1a2b3c4d5e)", for people.
std::string version_text();

}  // namespace credence
