#include <fmt/format.h>

#include <sstream>
#include <string_view>

#include "app/completion.h"
#include "core/append_item.h"
#include "core/version.h"

namespace credence::internal {
namespace {

/// Text of a line of roff: a backslash and a minus are themselves, a dot or quote at its beginning is no
/// command.
std::string roff(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return text.starts_with('.') || text.starts_with('\'') ? "\\&" + out : out;
}

std::string option_entry(const OptionShape& option) {
  std::string names;
  for (const std::string& name : option.names) append_item(names, fmt::format("\\fB{}\\fR", roff(name)));
  if (!option.positional && !option.value.empty()) names += fmt::format(" \\fI{}\\fR", roff(option.value));
  return fmt::format(".TP\n{}\n{}\n", names, roff(option.about));
}

/// "Examples:" and its lines, as they stand.
std::string literal(const std::string& text) {
  std::string out = ".PP\n.nf\n";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) out += roff(line) + "\n";
  return out + ".fi\n";
}

std::string command_section(const CommandShape& command) {
  std::string text = fmt::format(".SS credence {}", roff(command.name));
  for (const OptionShape& option : command.options) {
    if (!option.positional) continue;
    const char* const more = option.repeatable ? "..." : "";
    text += option.required ? fmt::format(" {}{}", option.names.front(), more)
                            : fmt::format(" [{}{}]", option.names.front(), more);
  }
  text += fmt::format("\n{}\n", roff(command.about));
  for (const OptionShape& option : command.options) text += option_entry(option);
  return command.footer.empty() ? text : text + literal(command.footer);
}

}  // namespace

std::string man_page(std::span<const CommandShape> commands) {
  std::string text = fmt::format(R"(.TH CREDENCE 1 "" "Credence {}"
.SH NAME
credence \- tells whether a filter's covariance can be trusted
.SH SYNOPSIS
.B credence
.I COMMAND
[\fIOPTIONS\fR]
.SH DESCRIPTION
Credence simulates many noisy runs of a SLAM or Kalman\-type filter, or reads its logs, tests NEES and NIS against the
laws they must follow, and says consistent, optimistic, pessimistic, mixed, not Gaussian or undecided.
.SH COMMANDS
)",
                                 roff(version()));
  for (const CommandShape& command : commands) text += command_section(command);
  return text + R"(.SH EXIT STATUS
.TP
0
done
.TP
1
an inconsistent verdict, with \-\-fail\-on\-inconsistent
.TP
2
bad input
.TP
3
some runs failed
.TP
130
interrupted, after saving
.SH ENVIRONMENT
.TP
NO_COLOR
set: no colours on a terminal
.TP
CREDENCE_DATA
folder of the data sets of \fBcredence replay\fR
)";
}

}  // namespace credence::internal
