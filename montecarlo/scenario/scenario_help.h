#pragma once

#include <string>

/// @file
/// What the table of keys says, for people.

namespace credence::internal {

/// All keys with default and accepted values as lines of at most 100 columns, for `--help`.
std::string scenario_help();

/// All keys as one Markdown table a section: the body of docs/scenario.md.
std::string scenario_reference();

}  // namespace credence::internal
