#pragma once

#include <span>
#include <string>

#include "app/command_tree.h"

/// @file
/// What a shell completes after `credence`: commands, options, their values, keys of --set, scenarios, files.

namespace credence::internal {

std::string bash_completion(std::span<const CommandShape> commands);
std::string zsh_completion(std::span<const CommandShape> commands);
std::string fish_completion(std::span<const CommandShape> commands);

/// The manual, section 1, in the language of man.
std::string man_page(std::span<const CommandShape> commands);

}  // namespace credence::internal
