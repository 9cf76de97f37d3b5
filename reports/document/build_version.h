#pragma once

#include <string_view>

namespace credence {

/// The version of the project, "0.1.0".
std::string_view build_version();

/// The commit that was built, "7966317c0de1", with "+" behind it where files had been changed; empty where
/// the sources were no repository.
std::string_view build_commit();

}  // namespace credence
