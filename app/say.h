#pragma once

#include <string_view>

namespace credence::internal {

/// Writes a line to stderr, where a command says what is no result: messages, and where its report is.
///
/// Names in it are other people's bytes: control characters and direction marks do not reach the terminal
/// (printable_line), but for the line breaks of a message of several lines. What cannot be written is
/// dropped: no work is lost for want of somebody to talk to.
void say(std::string_view line);

}  // namespace credence::internal
