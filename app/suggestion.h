#pragma once

#include <string>
#include <string_view>

namespace CLI {
class App;
}

/// @file
/// What may have been meant by a word that the command line does not know.

namespace credence::internal {

/// "; did you mean run?", else where the commands are listed.
std::string command_proposal(const CLI::App& app, std::string_view word);

/// The same of an option of a command. One that is called like a key of a scenario is proposed as --set.
std::string option_proposal(const CLI::App& command, std::string_view option);

}  // namespace credence::internal
