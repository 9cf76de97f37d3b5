#include "app/terminal_text.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "app/launched_ranks.h"
#include "reports/render/text_page.h"
#include "reports/render/text_table.h"

namespace credence::internal {
namespace {

/// Under mpirun every rank has a terminal of its own, whatever mpirun writes to.
bool is_terminal() { return isatty(STDOUT_FILENO) == 1 && launched_ranks() == nullptr; }

/// The wish of https://no-color.org, and of terminals that know no colours.
bool wants_colour() {
  const char* const no_colour = std::getenv("NO_COLOR");
  if (no_colour != nullptr && *no_colour != '\0') return false;
  const char* const terminal = std::getenv("TERM");
  return terminal == nullptr || std::string_view(terminal) != "dumb";
}

}  // namespace

std::size_t terminal_width(int descriptor) {
  winsize size{};
  if (isatty(descriptor) != 1 || ioctl(descriptor, TIOCGWINSZ, &size) != 0) return 0;
  return size.ws_col;
}

std::string terminal_text(const Document& document) {
  return text_page(document, is_terminal() && wants_colour(), terminal_width(STDOUT_FILENO));
}

std::string terminal_text(const ReportTable& table) {
  return text_table(table, is_terminal() && wants_colour(), terminal_width(STDOUT_FILENO));
}

}  // namespace credence::internal
