#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace credence::internal {

/// What is wrong with the arguments, in one sentence with a proposal, and where the right ones are listed.
std::string complaint(const CLI::App& app, const CLI::ParseError& error);

}  // namespace credence::internal
